//! MTL files: checked and rewritten line by line, read by tobj, turned into materials.
//!
//! tobj panics on a colour of one value, gives up the whole file at `Kd spectral`, and does not know `Tr`.

use super::lines::{Statement, for_each_statement};
use crate::{
    error::{Error, Result},
    scene::{Material, tally::Tally},
};
use glam::Vec3;
use std::{fmt::Write, path::Path};

/// The materials of the MTL file `path`, whose contents are `text`, in order.
pub(super) fn read(path: &Path, text: &str, tally: &mut Tally) -> Result<Vec<Material>> {
    let mut cleaner =
        Cleaner { path, tally, out: String::new(), in_material: false, opacity: None, transparency: None };
    for_each_statement(text, |statement| cleaner.statement(&statement))?;
    cleaner.close_material(0);
    let (materials, _) = tobj::load_mtl_buf(&mut cleaner.out.as_bytes())
        .map_err(|e| Error::file(path, format!("cannot be read ({e})"), "report this file to us"))?;
    Ok(materials.into_iter().map(convert).collect())
}

/// What the file leaves out is as in [`Material::default`].
fn convert(from: tobj::Material) -> Material {
    let default = Material::default();
    Material {
        name: from.name,
        ka: from.ambient.map_or(default.ka, Vec3::from),
        kd: from.diffuse.map_or(default.kd, Vec3::from),
        ks: from.specular.map_or(default.ks, Vec3::from),
        ke: from.emissive.map_or(default.ke, Vec3::from),
        ns: from.shininess.unwrap_or(default.ns),
        ni: from.optical_density.unwrap_or(default.ni),
        d: from.dissolve.unwrap_or(default.d),
        illum: from.illumination_model.unwrap_or(default.illum),
        ..default
    }
}

struct Cleaner<'a> {
    path: &'a Path,
    tally: &'a mut Tally,
    out: String,
    in_material: bool,
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
            self.in_material = true;
            let _ = writeln!(self.out, "newmtl {rest}");
            return Ok(());
        }
        if !self.in_material {
            self.tally.at(line, "statements before the first `newmtl` ignored");
            return Ok(());
        }
        match keyword {
            "Ka" | "Kd" | "Ks" | "Ke" => self.color(line, keyword, rest),
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
                self.tally.at(line, "textures ignored");
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

    fn color(&mut self, line: usize, keyword: &str, rest: &str) -> Result<()> {
        if rest.starts_with("spectral") || rest.starts_with("xyz") {
            self.tally.at(line, "colours given as `spectral` or `xyz` ignored");
            return Ok(());
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
            *value = self.limited(line, keyword, word, |c| c.max(0.0))?;
        }
        let _ = writeln!(self.out, "{keyword} {} {} {}", rgb[0], rgb[1], rgb[2]);
        Ok(())
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
    lower.starts_with("map_") || ["bump", "norm", "disp", "decal", "refl"].contains(&&*lower)
}
