//! Materials of a scene file: changes to those of the meshes, and new ones.

use super::{
    schema::{self, Map},
    source::Source,
};
use crate::{
    error::Result,
    scene::{
        Bump, BumpKind, Library, Material, Wrap,
        texture::{Mapping, Role, Textures},
    },
};
use glam::{DVec2, Vec2, Vec3};
use std::path::Path;
use toml::Spanned;

/// New values for the materials of a name.
#[derive(Default)]
pub(super) struct Change {
    pub(super) name: String,
    ka: Option<Vec3>,
    kd: Option<Vec3>,
    ks: Option<Vec3>,
    ke: Option<Vec3>,
    tf: Option<Vec3>,
    absorption: Option<Vec3>,
    ns: Option<f32>,
    ni: Option<f32>,
    d: Option<f32>,
    illum: Option<u8>,
    /// 0 is a perfect mirror.
    roughness: Option<f32>,
    map_kd: Option<Picture>,
    map_d: Option<Picture>,
    map_ke: Option<Picture>,
    bump: Option<(Picture, BumpKind, f32)>,
}

/// A picture file to be read.
struct Picture {
    file: Spanned<String>,
    mapping: Mapping,
}

pub(super) fn change(source: &Source<'_>, value: Spanned<schema::Material>) -> Result<Change> {
    let from = value.into_inner();
    let reflectance =
        |key, value: &Option<_>| value.as_ref().map(|value| source.reflectance(key, value)).transpose();
    let color = |key, value: &Option<_>| value.as_ref().map(|value| source.color(key, value)).transpose();
    let number = |key, value: &Option<_>, valid: fn(f32) -> bool, rule| {
        value.as_ref().map(|value| source.within(key, value, valid, rule)).transpose()
    };
    let share =
        |key, value: &Option<_>| number(key, value, |d| (0.0..=1.0).contains(&d), "must be in 0 to 1");
    let illum = from.illum.as_ref().map(|illum| {
        let valid = (0..=10).contains(illum.get_ref());
        source.check("illum", illum, valid, "must be in 0 to 10").map(|()| *illum.get_ref() as u8)
    });
    source.check("name", &from.name, !from.name.get_ref().is_empty(), "must not be empty")?;
    Ok(Change {
        name: from.name.get_ref().clone(),
        ka: reflectance("ka", &from.ka)?,
        kd: reflectance("kd", &from.kd)?,
        ks: reflectance("ks", &from.ks)?,
        ke: color("ke", &from.ke)?,
        tf: reflectance("tf", &from.tf)?,
        absorption: color("absorption", &from.absorption)?,
        ns: number("ns", &from.ns, |ns| ns >= 0.0, "must not be negative")?,
        ni: number("ni", &from.ni, |ni| ni > 0.0, "must be positive")?,
        d: share("d", &from.d)?,
        illum: illum.transpose()?,
        roughness: share("roughness", &from.roughness)?,
        map_kd: from.map_kd.map(|map| picture(source, map)).transpose()?,
        map_d: from.map_d.map(|map| picture(source, map)).transpose()?,
        map_ke: from.map_ke.map(|map| picture(source, map)).transpose()?,
        bump: bump(source, from.map_bump, from.norm)?,
    })
}

/// A picture that bends no normals.
fn picture(source: &Source<'_>, map: Map) -> Result<Picture> {
    for (key, value) in [("height", &map.height), ("strength", &map.strength)] {
        if let Some(value) = value {
            source.check(key, value, false, "belongs to `map_bump` or `norm` only")?;
        }
    }
    mapped(source, map)
}

fn mapped(source: &Source<'_>, map: Map) -> Result<Picture> {
    source.check("file", &map.file, !map.file.get_ref().is_empty(), "must not be empty")?;
    let pair = |key, value: &Option<Spanned<[f64; 2]>>, missing: Vec2| {
        let Some(value) = value else { return Ok(missing) };
        let pair = DVec2::from_array(*value.get_ref()).as_vec2();
        source.check(key, value, pair.is_finite(), "must be two finite numbers").map(|()| pair)
    };
    let mapping = Mapping {
        scale: pair("scale", &map.scale, Vec2::ONE)?,
        offset: pair("offset", &map.offset, Vec2::ZERO)?,
        wrap: match map.wrap {
            schema::Wrap::Repeat => Wrap::Repeat,
            schema::Wrap::Clamp => Wrap::Clamp,
        },
    };
    Ok(Picture { file: map.file, mapping })
}

fn bump(
    source: &Source<'_>,
    heights: Option<Map>,
    normals: Option<Map>,
) -> Result<Option<(Picture, BumpKind, f32)>> {
    let (map, kind, factor) = match (heights, normals) {
        (None, None) => return Ok(None),
        (Some(_), Some(map)) => {
            let what = "a material has either `map_bump` or `norm`";
            return Err(source.error(map.file.span(), what, "remove one of them"));
        }
        (Some(mut map), None) => {
            let Some(height) = map.height.take() else {
                let what = "`map_bump` needs `height`, how high white is in units of the scene";
                let remedy = "write it as { file = \"...\", height = 0.01 }";
                return Err(source.error(map.file.span(), what, remedy));
            };
            (map, BumpKind::Height, source.finite("height", &height)?)
        }
        (None, Some(mut map)) => {
            let strength = map.strength.take().map(|strength| source.finite("strength", &strength));
            (map, BumpKind::Normal, strength.transpose()?.unwrap_or(1.0))
        }
    };
    Ok(Some((picture(source, map)?, kind, factor)))
}

/// Where textures are looked for and what they become.
pub(super) struct Reader<'a> {
    pub(super) source: &'a Source<'a>,
    pub(super) library: &'a Library,
    /// Of the scene file.
    pub(super) folder: &'a Path,
    pub(super) textures: &'a mut Textures,
}

impl Reader<'_> {
    fn read(&mut self, picture: &Picture, role: Role) -> Result<u32> {
        let (name, span) = (picture.file.get_ref(), picture.file.span());
        let place = self.library.locate(self.folder, name);
        let path = place
            .require("texture", "put it there")
            .map_err(|(what, remedy)| self.source.error(span.clone(), what, remedy))?;
        self.textures.read(&path, role, picture.mapping).map_err(|fault| {
            let what = format!("texture `{}` {}", name.escape_debug(), fault.what);
            self.source.error(span, what, fault.remedy)
        })
    }
}

impl Change {
    /// Changes all materials of that name, or adds one.
    pub(super) fn apply(&self, materials: &mut Vec<Material>, reader: &mut Reader<'_>) -> Result<()> {
        if !materials.iter().any(|material| material.name == self.name) {
            materials.push(Material { name: self.name.clone(), ..Material::default() });
        }
        let mut read = |picture: &Option<Picture>, role| {
            picture.as_ref().map(|picture| reader.read(picture, role)).transpose()
        };
        let map_kd = read(&self.map_kd, Role::Color)?;
        let map_d = read(&self.map_d, Role::Opacity)?;
        let map_ke = read(&self.map_ke, Role::Color)?;
        let bump = match &self.bump {
            None => None,
            Some((picture, kind, strength)) => {
                let role = match kind {
                    BumpKind::Height => Role::Height,
                    BumpKind::Normal => Role::Normal,
                };
                Some(Bump { texture: reader.read(picture, role)?, kind: *kind, strength: *strength })
            }
        };
        for material in materials.iter_mut().filter(|material| material.name == self.name) {
            material.ka = self.ka.unwrap_or(material.ka);
            material.kd = self.kd.unwrap_or(material.kd);
            material.ks = self.ks.unwrap_or(material.ks);
            material.ke = self.ke.unwrap_or(material.ke);
            material.tf = self.tf.unwrap_or(material.tf);
            material.absorption = self.absorption.unwrap_or(material.absorption);
            material.ns = self.ns.unwrap_or(material.ns);
            material.ni = self.ni.unwrap_or(material.ni);
            material.d = self.d.unwrap_or(material.d);
            material.illum = self.illum.unwrap_or(material.illum);
            material.roughness = match self.roughness {
                None => material.roughness,
                given => given.filter(|&roughness| roughness > 0.0),
            };
            material.map_kd = map_kd.or(material.map_kd);
            material.map_d = map_d.or(material.map_d);
            material.map_ke = map_ke.or(material.map_ke);
            material.bump = bump.or(material.bump);
        }
        Ok(())
    }
}
