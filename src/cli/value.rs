//! Parsers of single values. Each failure reads on after the flag: "what is wrong; the remedy".

use crate::{
    bvh::BuildPreset,
    kernels::{Isa, Visibility},
    scene::{MAX_PIXELS, MAX_SIDE},
    schedule::{FilmMode, Strategy},
    study::{
        bench::{Engine, Kind},
        coherence::ShadowRays,
        stability::Kernel,
    },
    tile::Order,
    trace::KernelChoice,
};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use glam::Vec3;
use std::{fmt::Display, ops::RangeInclusive, str::FromStr};

/// A mode of the library: the values it can take and their names are told by its own module, nowhere else.
pub(super) trait Mode: Copy + Send + Sync + 'static {
    /// Every value there is.
    fn all() -> impl Iterator<Item = Self>;
    /// Name on the command line and in reports.
    fn name(self) -> &'static str;
}

macro_rules! modes {
    ($($mode:ty),*) => {$(
        impl Mode for $mode {
            fn all() -> impl Iterator<Item = Self> {
                <$mode>::ALL.into_iter()
            }

            fn name(self) -> &'static str {
                <$mode>::name(self)
            }
        }
    )*};
}

modes!(
    BuildPreset,
    Engine,
    FilmMode,
    Isa,
    Kernel,
    KernelChoice,
    Kind,
    Order,
    ShadowRays,
    Strategy,
    Visibility
);

/// What `--isa` takes.
#[derive(Clone, Copy, Debug)]
pub(super) enum IsaChoice {
    /// The widest one of this machine.
    Auto,
    /// This one or an error.
    Only(Isa),
}

impl IsaChoice {
    /// `None` for the widest one of this machine.
    pub(super) fn isa(self) -> Option<Isa> {
        match self {
            IsaChoice::Auto => None,
            IsaChoice::Only(isa) => Some(isa),
        }
    }
}

impl Mode for IsaChoice {
    fn all() -> impl Iterator<Item = Self> {
        std::iter::once(IsaChoice::Auto).chain(Isa::all().map(IsaChoice::Only))
    }

    fn name(self) -> &'static str {
        self.isa().map_or("auto", Isa::name)
    }
}

/// Takes the name of a mode's value; `--help` and errors list them.
pub(super) fn one_of<M: Mode>() -> impl TypedValueParser<Value = M> {
    PossibleValuesParser::new(M::all().map(M::name)).try_map(|name| {
        M::all().find(|mode| mode.name() == name).ok_or_else(|| format!("'{name}' is not available"))
    })
}

/// Takes a whole number in `range`.
pub(super) fn whole<N>(range: RangeInclusive<N>) -> impl Fn(&str) -> Result<N, String> + Clone
where
    N: FromStr + PartialOrd + Display + Clone,
{
    move |text| {
        text.trim().parse().ok().filter(|number| range.contains(number)).ok_or_else(|| {
            format!(
                "'{text}' is not a whole number in range; give one from {} to {}",
                range.start(),
                range.end()
            )
        })
    }
}

/// Takes a finite number.
pub(super) fn number(text: &str) -> Result<f32, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|number: &f32| number.is_finite())
        .ok_or_else(|| format!("'{text}' is not a finite number; give one such as 1.5"))
}

/// Takes a share of a whole.
pub(super) fn share(text: &str) -> Result<f32, String> {
    number(text)
        .ok()
        .filter(|share| (0.0..=1.0).contains(share))
        .ok_or_else(|| format!("'{text}' is no share; give a number from 0 to 1"))
}

/// Takes a share of a whole, above none of it.
pub(super) fn positive_share(text: &str) -> Result<f32, String> {
    share(text)
        .ok()
        .filter(|&share| share > 0.0)
        .ok_or_else(|| format!("'{text}' is no such share; give a number above 0 and up to 1"))
}

/// Takes a vertical field of view in degrees.
pub(super) fn field_of_view(text: &str) -> Result<f32, String> {
    number(text).ok().filter(|&degrees| degrees > 0.0 && degrees < 180.0).ok_or_else(|| {
        format!("'{text}' is no angle of view; give degrees between 0 and 180, both excluded, such as 50")
    })
}

/// Takes X,Y,Z.
pub(super) fn vector(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|part| number(part).ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("'{text}' is not a vector; give three finite numbers such as 1,2.5,-3")),
    }
}

/// Takes LATENCY,SPEED of a network, in microseconds and Gb/s; returns seconds and bits per second.
pub(super) fn network(text: &str) -> Result<(f64, f64), String> {
    let positive = |text: &str| text.trim().parse().ok().filter(|&x: &f64| x.is_finite() && x > 0.0);
    text.split_once(',')
        .and_then(|(latency, speed)| Some((positive(latency)? * 1e-6, positive(speed)? * 1e9)))
        .ok_or_else(|| {
            format!("'{text}' is not a network; give its latency in microseconds and its Gb/s, such as 10,10")
        })
}

/// Takes a factor of at least 1.
pub(super) fn factor(text: &str) -> Result<f64, String> {
    let factor = text.trim().parse().ok().filter(|&x: &f64| x.is_finite() && (1.0..=100.0).contains(&x));
    factor.ok_or_else(|| format!("'{text}' is not a factor; give a number from 1 to 100, such as 1.05"))
}

/// Takes a root of a mean square error.
pub(super) fn max_error(text: &str) -> Result<f64, String> {
    let error = text.trim().parse().ok().filter(|error: &f64| *error > 0.0 && *error <= 1.0);
    error.ok_or_else(|| {
        format!("'{text}' is no error; give an RMSE greater than 0 and at most 1, such as 0.01")
    })
}

/// Takes seconds of a render.
pub(super) fn budget(text: &str) -> Result<f64, String> {
    let seconds = text.trim().parse().ok().filter(|seconds: &f64| *seconds > 0.0 && *seconds <= 1.0e6);
    seconds.ok_or_else(|| format!("'{text}' is no time; give seconds up to 1000000, such as 2.5"))
}

/// Takes milliseconds of a frame.
pub(super) fn milliseconds(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|ms: &f64| (1.0..=10000.0).contains(ms));
    number.ok_or_else(|| format!("'{text}' is no frame time; give milliseconds from 1 to 10000, such as 33"))
}

/// Takes a moment in seconds.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|seconds: &f64| *seconds >= 0.0 && seconds.is_finite());
    number.ok_or_else(|| format!("'{text}' is no moment; give seconds, such as 1.5"))
}

/// Takes images per second.
pub(super) fn rate(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|rate: &f64| *rate > 0.0 && *rate <= 1000.0);
    number.ok_or_else(|| format!("'{text}' is no rate; give images per second, at most 1000, such as 24"))
}

/// Takes WxH.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.trim().parse().ok().filter(|&side: &u32| side >= 1);
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([side(w)?, side(h)?]));
    let Some([width, height]) = sides else {
        return Err(format!("'{text}' is not an image size; give WIDTHxHEIGHT in pixels, such as 1280x720"));
    };
    if width.max(height) > MAX_SIDE || u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(format!(
            "{width}x{height} pixels are too many; stay within {MAX_PIXELS} pixels and {MAX_SIDE} a side"
        ));
    }
    Ok([width, height])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_positive_and_bounded() {
        assert_eq!(size("1280x720"), Ok([1280, 720]));
        assert_eq!(size("1X1"), Ok([1, 1]));
        assert_eq!(size("16384x16384"), Ok([16384, 16384]));
        for bad in [
            "",
            "x",
            "100",
            "0x5",
            "5x0",
            "-1x5",
            "1.5x2",
            "1x2x3",
            "99999999999x1",
            "65537x1",
            "16385x16384",
        ] {
            let message = size(bad).unwrap_err();
            assert!(message.contains("; "), "{message}");
        }
    }

    #[test]
    fn vectors_have_three_finite_numbers() {
        assert_eq!(vector("1,-2.5,3e2"), Ok(Vec3::new(1.0, -2.5, 300.0)));
        assert_eq!(vector(" 1, 2 ,3"), Ok(Vec3::new(1.0, 2.0, 3.0)));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "1,,3", "nan,0,0", "inf,0,0", "1e39,0,0"] {
            assert!(vector(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn angles_lie_strictly_between_0_and_180() {
        assert_eq!(field_of_view("50"), Ok(50.0));
        for bad in ["0", "180", "-1", "nan", "inf", "x"] {
            assert!(field_of_view(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn whole_numbers_stay_in_range() {
        let few = whole(1..=4u32);
        assert_eq!([few("1"), few("4")], [Ok(1), Ok(4)]);
        for bad in ["0", "5", "-1", "1.0", "99999999999", "x", ""] {
            assert!(few(bad).unwrap_err().ends_with("give one from 1 to 4"), "{bad}");
        }
    }

    #[test]
    fn every_mode_is_taken_by_its_name() {
        fn names<M: Mode>() -> Vec<&'static str> {
            M::all().map(M::name).collect()
        }
        assert_eq!(names::<IsaChoice>(), ["auto", "scalar", "sse4.2", "avx2", "avx512"]);
        assert_eq!(names::<Visibility>(), ["exact", "fast"]);
        assert!(names::<Order>().contains(&"hilbert") && names::<Strategy>().contains(&"dynamic"));
    }
}
