//! Textures of materials: the name of a file, or a table with more about it.

use serde::{Deserialize, Deserializer, de};
use std::fmt;
use toml::Spanned;

/// A texture: `"wood.png"`, or `{ file = "wood.png", scale = [2, 2] }`.
#[derive(Debug)]
pub(in crate::scene::description) struct Map {
    /// The whole of it is at this place.
    pub(in crate::scene::description) file: Spanned<String>,
    pub(in crate::scene::description) scale: Option<Spanned<[f64; 2]>>,
    pub(in crate::scene::description) offset: Option<Spanned<[f64; 2]>>,
    pub(in crate::scene::description) wrap: Wrap,
    /// Of a height map: the height of white, in units of the scene.
    pub(in crate::scene::description) height: Option<Spanned<f64>>,
    /// Of a normal map: factor of the slopes.
    pub(in crate::scene::description) strength: Option<Spanned<f64>>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(in crate::scene::description) enum Wrap {
    #[default]
    Repeat,
    Clamp,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    file: String,
    scale: Option<Spanned<[f64; 2]>>,
    offset: Option<Spanned<[f64; 2]>>,
    #[serde(default)]
    wrap: Wrap,
    height: Option<Spanned<f64>>,
    strength: Option<Spanned<f64>>,
}

/// Either form, without its place.
struct Either(Table);

impl<'de> Deserialize<'de> for Map {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Map, D::Error> {
        let value = Spanned::<Either>::deserialize(deserializer)?;
        let span = value.span();
        let Table { file, scale, offset, wrap, height, strength } = value.into_inner().0;
        Ok(Map { file: Spanned::new(span, file), scale, offset, wrap, height, strength })
    }
}

impl<'de> Deserialize<'de> for Either {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Either, D::Error> {
        deserializer.deserialize_any(MapVisitor)
    }
}

struct MapVisitor;

impl<'de> de::Visitor<'de> for MapVisitor {
    type Value = Either;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a picture file or a table with `file`")
    }

    fn visit_str<E: de::Error>(self, file: &str) -> Result<Either, E> {
        Ok(Either(Table {
            file: file.into(),
            scale: None,
            offset: None,
            wrap: Wrap::Repeat,
            height: None,
            strength: None,
        }))
    }

    fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<Either, A::Error> {
        Table::deserialize(de::value::MapAccessDeserializer::new(map)).map(Either)
    }
}
