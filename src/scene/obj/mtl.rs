//! MTL files: checked and rewritten line by line, read by tobj, turned into materials.
//!
//! tobj panics on a colour of one value, gives up the whole file at `Kd spectral`, and does not know `Tr`.

use super::{
    lines::{Statement, for_each_statement},
    maps::{self, MapStatement, Slot},
};
use crate::{
    error::{Error, Result},
    scene::{Material, tally::Tally},
};
use glam::Vec3;
use std::{fmt::Write, path::Path};

/// A material with the textures that are still to be read.
#[derive(Debug)]
pub(super) struct Unread {
    pub(super) material: Material,
    pub(super) maps: Vec<MapStatement>,
}

/// The materials of the MTL file `path`, whose contents are `text`, in order.
pub(super) fn read(path: &Path, text: &str, tally: &mut Tally) -> Result<Vec<Unread>> {
    let mut cleaner =
        Cleaner { path, tally, out: String::new(), extras: Vec::new(), opacity: None, transparency: None };
    for_each_statement(text, |statement| cleaner.statement(&statement))?;
    cleaner.close_material(0);
    let (materials, _) = tobj::load_mtl_buf(&mut cleaner.out.as_bytes())
        .map_err(|e| Error::file(path, format!("cannot be read ({e})"), "report this file to us"))?;
    Ok(materials.into_iter().zip(cleaner.extras).map(|(from, extra)| convert(from, extra)).collect())
}

/// What tobj does not know of a material.
#[derive(Default)]
struct Extra {
    tf: Option<Vec3>,
    roughness: Option<f32>,
    maps: Vec<MapStatement>,
}

/// What the file leaves out is as in [`Material::default`].
fn convert(from: tobj::Material, extra: Extra) -> Unread {
    let default = Material::default();
    let material = Material {
        name: from.name,
        ka: from.ambient.map_or(default.ka, Vec3::from),
        kd: from.diffuse.map_or(default.kd, Vec3::from),
        ks: from.specular.map_or(default.ks, Vec3::from),
        ke: from.emissive.map_or(default.ke, Vec3::from),
        ns: from.shininess.unwrap_or(default.ns),
        ni: from.optical_density.unwrap_or(default.ni),
        d: from.dissolve.unwrap_or(default.d),
        illum: from.illumination_model.unwrap_or(default.illum),
        tf: extra.tf.unwrap_or(default.tf),
        // 0 is a perfect mirror.
        roughness: extra.roughness.filter(|&roughness| roughness > 0.0),
        ..default
    };
    Unread { material, maps: extra.maps }
}

struct Cleaner<'a> {
    path: &'a Path,
    tally: &'a mut Tally,
    out: String,
    /// One for each `newmtl` so far.
    extras: Vec<Extra>,
    /// `d` of the current material.
    opacity: Option<f32>,
    /// `Tr` of the current material.
    transparency: Option<f32>,
}

impl Cleaner<'_> {
    fn statement(&mut self, &Statement { line, keyword, rest }: &Statement<'_>) -> Result<()> {
        if keyword == "newmtl" {
            if rest.is_empty() {
                return Err(Error::line(self.path, line, "`newmtl` without a name", "name the material"));
            }
            self.close_material(line);
            self.extras.push(Extra::default());
            let _ = writeln!(self.out, "newmtl {rest}");
            return Ok(());
        }
        if self.extras.is_empty() {
            self.tally.at(line, "statements before the first `newmtl` ignored");
            return Ok(());
        }
        if let Some(slot) = Slot::of(keyword) {
            let map = maps::parse(self.path, line, keyword, slot, rest, self.tally)?;
            self.extra().maps.push(map);
            return Ok(());
        }
        match keyword {
            "Ka" | "Kd" | "Ks" | "Ke" => {
                if let Some([r, g, b]) = self.color(line, keyword, rest, |c| c.max(0.0))? {
                    let _ = writeln!(self.out, "{keyword} {r} {g} {b}");
                }
                Ok(())
            }
            "Tf" => {
                self.extra().tf = self.color(line, keyword, rest, |c| c.clamp(0.0, 1.0))?.map(Vec3::from);
                Ok(())
            }
            "Pr" => {
                let roughness = self.limited(line, keyword, rest, |pr| pr.clamp(0.0, 1.0))?;
                self.extra().roughness = Some(roughness);
                Ok(())
            }
            "Ns" => self.scalar(line, keyword, rest, |ns| ns.max(0.0)),
            // Exporters write 0 for "not set".
            "Ni" => self.scalar(line, keyword, rest, |ni| if ni > 0.0 { ni } else { 1.0 }),
            "illum" => self.scalar(line, keyword, rest, |illum| {
                if (0.0..=10.0).contains(&illum) { illum.round() } else { 2.0 }
            }),
            "d" => {
                let value = rest.strip_prefix("-halo").unwrap_or(rest);
                if value.len() < rest.len() {
                    self.tally.at(line, "`-halo` ignored");
                }
                self.opacity = Some(self.limited(line, keyword, value, |d| d.clamp(0.0, 1.0))?);
                Ok(())
            }
            "Tr" => {
                self.transparency = Some(self.limited(line, keyword, rest, |tr| tr.clamp(0.0, 1.0))?);
                Ok(())
            }
            _ if is_texture(keyword) => {
                self.tally.at(line, "textures of unsupported kinds ignored");
                Ok(())
            }
            _ => {
                let keyword: String = keyword.chars().take(20).collect();
                self.tally.at(line, &format!("unsupported statement `{}` ignored", keyword.escape_debug()));
                Ok(())
            }
        }
    }

    /// Writes the opacity, which may have been given either way round.
    fn close_material(&mut self, line: usize) {
        let (d, tr) = (self.opacity.take(), self.transparency.take());
        if let (Some(d), Some(tr)) = (d, tr)
            && (d - (1.0 - tr)).abs() > 1.0e-3
        {
            self.tally.at(line.max(1), "materials whose `d` and `Tr` contradict each other (`d` used)");
        }
        if let Some(d) = d.or(tr.map(|tr| 1.0 - tr)) {
            let _ = writeln!(self.out, "d {d}");
        }
    }

    /// The material that statements are about.
    fn extra(&mut self) -> &mut Extra {
        self.extras.last_mut().expect("statements before the first material are skipped")
    }

    /// One or three numbers; none if they are not colours.
    fn color(
        &mut self,
        line: usize,
        keyword: &str,
        rest: &str,
        limit: impl Fn(f32) -> f32,
    ) -> Result<Option<[f32; 3]>> {
        if rest.starts_with("spectral") || rest.starts_with("xyz") {
            self.tally.at(line, "colours given as `spectral` or `xyz` ignored");
            return Ok(None);
        }
        let words: Vec<&str> = rest.split_whitespace().collect();
        let words = match words[..] {
            [grey] => [grey; 3],
            [r, g, b] => [r, g, b],
            _ => {
                let what = format!("`{keyword}` needs one or three numbers, not {}", words.len());
                return Err(Error::line(self.path, line, what, "correct the line"));
            }
        };
        let mut rgb = [0.0; 3];
        for (value, word) in rgb.iter_mut().zip(words) {
            *value = self.limited(line, keyword, word, &limit)?;
        }
        Ok(Some(rgb))
    }

    fn scalar(&mut self, line: usize, keyword: &str, rest: &str, limit: impl Fn(f32) -> f32) -> Result<()> {
        let value = self.limited(line, keyword, rest, limit)?;
        let _ = writeln!(self.out, "{keyword} {value}");
        Ok(())
    }

    /// A finite number brought into its range, which is counted where it changes anything.
    fn limited(&mut self, line: usize, keyword: &str, rest: &str, limit: impl Fn(f32) -> f32) -> Result<f32> {
        let word = rest.split_whitespace().next().unwrap_or_default();
        let value = word.parse::<f32>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
            let what = format!("`{keyword}` needs a finite number, not `{word}`");
            Error::line(self.path, line, what, "correct the line")
        })?;
        let limited = limit(value);
        if limited != value {
            self.tally.at(line, &format!("values of `{keyword}` out of range brought into it"));
        }
        Ok(limited)
    }
}

fn is_texture(keyword: &str) -> bool {
    let lower = keyword.to_ascii_lowercase();
    lower.starts_with("map_") || ["disp", "decal", "refl"].contains(&&*lower)
}
