//! The text of a scene file and the checks that name a place in it.

use super::schema::Triple;
use crate::{
    error::{Error, Result},
    scene::MAX_COORDINATE,
};
use glam::{DVec3, Vec3};
use std::{ops::Range, path::Path};
use toml::Spanned;

/// A scene file's path and text, to turn byte offsets into lines and columns.
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl Source<'_> {
    /// An error about the bytes at `span`, which says line and column.
    pub(super) fn error(&self, span: Range<usize>, what: impl ToString, remedy: impl ToString) -> Error {
        let end = (0..=span.start.min(self.text.len()))
            .rev()
            .find(|&at| self.text.is_char_boundary(at))
            .unwrap_or_default();
        let before = &self.text[..end];
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        Error::line(self.path, line, format!("column {column}: {}", what.to_string()), remedy)
    }

    /// What the TOML parser has to say.
    pub(super) fn syntax(&self, error: &toml::de::Error) -> Error {
        let message = error.message().trim().replace('\n', ", ");
        self.error(error.span().unwrap_or(0..0), message, "see scenes/README.md for all keys")
    }

    /// A number that is finite as f32.
    pub(super) fn finite(&self, key: &str, value: &Spanned<f64>) -> Result<f32> {
        self.check(key, value, (*value.get_ref() as f32).is_finite(), "must be finite")?;
        Ok(*value.get_ref() as f32)
    }

    /// Three numbers that can be coordinates.
    pub(super) fn vector(&self, key: &str, value: &Spanned<[f64; 3]>) -> Result<Vec3> {
        let vector = DVec3::from_array(*value.get_ref()).as_vec3();
        let valid = vector.is_finite() && vector.abs().max_element() <= MAX_COORDINATE;
        self.check(key, value, valid, &format!("must be three finite numbers, at most {MAX_COORDINATE:e}"))?;
        Ok(vector)
    }

    /// The same, as unit vector.
    pub(super) fn direction(&self, key: &str, value: &Spanned<[f64; 3]>) -> Result<Vec3> {
        self.vector(key, value)?;
        let direction = DVec3::from_array(*value.get_ref()).try_normalize().map(|d| d.as_vec3());
        direction.ok_or_else(|| self.invalid(key, value, "must not have zero length"))
    }

    /// A colour or other triple that is finite and not negative.
    pub(super) fn color(&self, key: &str, value: &Spanned<Triple>) -> Result<Vec3> {
        let color = DVec3::from_array(value.get_ref().0).as_vec3();
        let valid = color.is_finite() && color.min_element() >= 0.0;
        self.check(key, value, valid, "must be finite and not negative")?;
        Ok(color)
    }

    /// A colour with no component above 1: more cannot be reflected.
    pub(super) fn reflectance(&self, key: &str, value: &Spanned<Triple>) -> Result<Vec3> {
        let color = self.color(key, value)?;
        self.check(key, value, color.max_element() <= 1.0, "must be in 0 to 1")?;
        Ok(color)
    }

    /// A number in `range`, as f32.
    pub(super) fn within(
        &self,
        key: &str,
        value: &Spanned<f64>,
        valid: impl Fn(f32) -> bool,
        rule: &str,
    ) -> Result<f32> {
        let number = self.finite(key, value)?;
        self.check(key, value, valid(number), rule)?;
        Ok(number)
    }

    /// An error that names the key unless `valid`.
    pub(super) fn check<T>(&self, key: &str, value: &Spanned<T>, valid: bool, rule: &str) -> Result<()> {
        if valid { Ok(()) } else { Err(self.invalid(key, value, rule)) }
    }

    fn invalid<T>(&self, key: &str, value: &Spanned<T>, rule: &str) -> Error {
        let given = self.text.get(value.span()).unwrap_or_default();
        let given: String = given.chars().take(60).collect();
        self.error(value.span(), format!("`{key}` {rule}"), format!("change {}", given.escape_debug()))
    }
}
