//! Colours and factors.

use serde::{Deserialize, Deserializer, de};
use std::fmt;

/// Three numbers, or one that stands for three equal ones.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene::description) struct Triple(pub(in crate::scene::description) [f64; 3]);

impl<'de> Deserialize<'de> for Triple {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Triple, D::Error> {
        deserializer.deserialize_any(TripleVisitor)
    }
}

struct TripleVisitor;

impl<'de> de::Visitor<'de> for TripleVisitor {
    type Value = Triple;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or an array of three numbers")
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Triple, E> {
        Ok(Triple([value; 3]))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<Triple, E> {
        Ok(Triple([value as f64; 3]))
    }

    fn visit_seq<A: de::SeqAccess<'de>>(self, mut seq: A) -> Result<Triple, A::Error> {
        let mut values = [0.0; 3];
        for (index, value) in values.iter_mut().enumerate() {
            *value = seq.next_element()?.ok_or_else(|| de::Error::invalid_length(index, &self))?;
        }
        match seq.next_element::<f64>()? {
            None => Ok(Triple(values)),
            Some(_) => Err(de::Error::invalid_length(4, &self)),
        }
    }
}
