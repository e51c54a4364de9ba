//! Texture statements of MTL files: `map_Kd [options] file`.
//!
//! Options stand before the file's name, which may hold spaces. Those that irt follows are `-s` and `-o` (scale and
//! offset of the coordinates), `-clamp` and, for heights, `-bm`; the others are counted and skipped.

use crate::{
    error::{Error, Result},
    scene::{
        tally::Tally,
        texture::{Mapping, Role, Wrap},
    },
};
use glam::Vec2;
use std::path::Path;

/// What a texture is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// `map_Kd`
    Diffuse,
    /// `map_d`
    Opacity,
    /// `map_Ke`
    Emission,
    /// `map_Bump`, `bump`
    Height,
    /// `norm`
    Normal,
}

impl Slot {
    /// The slot that a keyword fills, in any case; none for textures that irt does not use.
    pub(super) fn of(keyword: &str) -> Option<Slot> {
        match &*keyword.to_ascii_lowercase() {
            "map_kd" => Some(Slot::Diffuse),
            "map_d" => Some(Slot::Opacity),
            "map_ke" => Some(Slot::Emission),
            "map_bump" | "bump" => Some(Slot::Height),
            "norm" | "map_kn" => Some(Slot::Normal),
            _ => None,
        }
    }

    /// What its pictures mean.
    pub(super) fn role(self) -> Role {
        match self {
            Slot::Diffuse | Slot::Emission => Role::Color,
            Slot::Opacity => Role::Opacity,
            Slot::Height => Role::Height,
            Slot::Normal => Role::Normal,
        }
    }
}

/// A texture statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapStatement {
    pub(super) slot: Slot,
    /// As the MTL file names it.
    pub(super) file: String,
    /// Line of the statement, from 1.
    pub(super) line: usize,
    pub(super) mapping: Mapping,
    /// `-bm`, 1 if missing.
    pub(super) multiplier: f32,
}

/// How many values an option has at least and at most.
fn arity(option: &str) -> Option<(usize, usize)> {
    match option {
        "-blendu" | "-blendv" | "-boost" | "-cc" | "-clamp" | "-bm" | "-imfchan" | "-texres" | "-type" => {
            Some((1, 1))
        }
        "-mm" => Some((2, 2)),
        "-o" | "-s" | "-t" => Some((1, 3)),
        _ => None,
    }
}

/// Reads the statement `keyword rest` of line `line` of the MTL file `path`.
pub(super) fn parse(
    path: &Path,
    line: usize,
    keyword: &str,
    slot: Slot,
    rest: &str,
    tally: &mut Tally,
) -> Result<MapStatement> {
    let error = |what: String| Err(Error::line(path, line, what, "correct the line"));
    let mut map =
        MapStatement { slot, file: String::new(), line, mapping: Mapping::IDENTITY, multiplier: 1.0 };
    let mut rest = rest;
    while let Some((least, most)) = arity(first_word(rest).0) {
        let (option, mut after) = first_word(rest);
        let mut values = Vec::new();
        while values.len() < most {
            let (word, next) = first_word(after);
            // The optional ones are numbers, and a file's name must be left.
            let optional = values.len() >= least;
            if word.is_empty() || optional && (word.parse::<f32>().is_err() || next.is_empty()) {
                break;
            }
            values.push(word);
            after = next;
        }
        if values.len() < least {
            return error(format!("`{option}` of `{keyword}` lacks a value"));
        }
        if !map.take(option, &values) {
            let given = values.join(" ");
            return error(format!("`{option} {given}` of `{keyword}` is not understood"));
        }
        if !matches!(option, "-s" | "-o" | "-bm" | "-clamp") {
            tally.at(line, &format!("option `{option}` of textures ignored"));
        }
        rest = after;
    }
    if rest.is_empty() {
        return error(format!("`{keyword}` without a file"));
    }
    map.file = rest.trim_matches('"').into();
    Ok(map)
}

impl MapStatement {
    /// Follows an option. False if its values have no meaning.
    fn take(&mut self, option: &str, values: &[&str]) -> bool {
        let number = |i: usize, missing: f32| match values.get(i) {
            None => Some(missing),
            Some(word) => word.parse().ok().filter(|value: &f32| value.is_finite()),
        };
        let pair = |missing: f32| Some(Vec2::new(number(0, missing)?, number(1, missing)?));
        match option {
            "-s" => pair(1.0).map(|scale| self.mapping.scale = scale).is_some(),
            "-o" => pair(0.0).map(|offset| self.mapping.offset = offset).is_some(),
            "-bm" => number(0, 1.0).map(|multiplier| self.multiplier = multiplier).is_some(),
            "-clamp" => {
                let clamp = values[0] == "on";
                self.mapping.wrap = if clamp { Wrap::Clamp } else { Wrap::Repeat };
                clamp || values[0] == "off"
            }
            _ => true,
        }
    }
}

/// The first word and what follows it.
fn first_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(rest: &str) -> std::result::Result<MapStatement, String> {
        let mut tally = Tally::new("a.mtl");
        parse(Path::new("a.mtl"), 7, "map_Kd", Slot::Diffuse, rest, &mut tally).map_err(|e| e.to_string())
    }

    #[test]
    fn options_are_followed_or_skipped_and_names_hold_spaces() {
        let plain = read("wood.png").expect("a name");
        assert_eq!((&*plain.file, plain.mapping, plain.multiplier), ("wood.png", Mapping::IDENTITY, 1.0));
        let all =
            read("-s 2 3 1 -o 0.5 -clamp on -bm -2 -texres 512 -mm 0 1 my wood 2.png").expect("options");
        assert_eq!(&*all.file, "my wood 2.png");
        assert_eq!((all.mapping.scale, all.mapping.offset), (Vec2::new(2.0, 3.0), Vec2::new(0.5, 0.0)));
        assert_eq!((all.mapping.wrap, all.multiplier), (Wrap::Clamp, -2.0));
        // A number may be a name.
        assert_eq!(read("-s 2 3 4").expect("a name").file, "4");
        assert_eq!(read("-imfchan l -cc off \"a b.png\"").expect("a name").file, "a b.png");
    }

    #[test]
    fn mistakes_name_the_line() {
        for (rest, what) in [
            ("", "`map_Kd` without a file"),
            ("-clamp on", "`map_Kd` without a file"),
            ("-bm", "`-bm` of `map_Kd` lacks a value"),
            ("-bm x a.png", "`-bm x` of `map_Kd` is not understood"),
            ("-s nan a.png", "`-s nan` of `map_Kd` is not understood"),
            ("-clamp maybe a.png", "`-clamp maybe` of `map_Kd` is not understood"),
        ] {
            assert_eq!(read(rest), Err(format!("a.mtl:7: {what}; correct the line")), "{rest}");
        }
    }
}
