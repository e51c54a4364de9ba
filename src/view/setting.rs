//! The modes that can be switched while the picture is there, by name and value: what `set` of a script takes.

use super::overlay::Overlay;
use crate::{
    effects::{EffectChoice, EffectSet},
    kernels::{Isa, Visibility},
    render::{RenderOptions, choose_kernels},
    schedule::{FilmMode, Strategy},
    tile::Order,
    trace::{EarlyTermination, KernelChoice},
};
use std::fmt::Display;
use std::str::FromStr;
use std::time::Duration;

/// One mode and its new value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// Order of the tiles.
    Order(Order),
    /// Which worker gets which tile when.
    Schedule(Strategy),
    /// How pixels reach the film.
    Film(FilmMode),
    /// Workers; 0 for one per core.
    Threads(usize),
    /// Pin each worker to a core.
    Pin(bool),
    /// Instruction set; `None` for the widest.
    Isa(Option<Isa>),
    /// How hits are decided.
    Visibility(Visibility),
    /// Kernel for rays with a common origin.
    Kernel(KernelChoice),
    /// Which searches end early.
    Early(EarlyTermination),
    /// Side of a tile in pixels.
    Tile(u32),
    /// Brightness of what is shown, in stops.
    Exposure(f32),
    /// Vertical angle of view in degrees.
    Fov(f32),
    /// The camera flies instead of orbiting.
    Fly(bool),
    /// How long a frame may take while the camera moves.
    FrameTime(Duration),
    /// What is laid over the picture.
    Overlay(Overlay),
    /// At rest, pixels that differ from others get more samples.
    AntiAliasing(bool),
    /// Which effects are simulated, and by which kernel.
    Effects(EffectChoice),
    /// The moment of a scene that moves, in seconds.
    Time(f64),
    /// Time passes.
    Play(bool),
}

/// Names and values, as a script has them.
pub const NAMES: [(&str, &str); 19] = [
    ("order", "scanline, serpentine, hilbert, morton or peano"),
    (
        "schedule",
        "static, static-cyclic, dynamic, overlap, non-blocking, refinement, stealing or cost-guided",
    ),
    ("film", "shared or messages"),
    ("threads", "a number of workers up to 1024, or auto"),
    ("pin", "on or off"),
    ("isa", "auto, scalar, sse4.2, avx2 or avx512, as far as this machine has it"),
    ("visibility", "exact or fast"),
    ("kernel", "auto, tile or single"),
    ("early-termination", "none, or some of pet-bound,pet-seed,set,occ,area"),
    ("tile", "pixels along the side of a tile, 1 to 1024"),
    ("exposure", "stops from -50 to 50"),
    ("fov", "degrees between 0 and 180"),
    ("camera", "orbit or fly"),
    ("frame-time", "milliseconds, 1 to 10000"),
    ("overlay", "none, workers, samples, time, steps, lanes or coherence"),
    ("anti-aliasing", "on or off"),
    ("effects", "auto, all, a list of effects with commas between, or without=LIST"),
    ("time", "seconds from the beginning of the motion"),
    ("motion", "play or stop"),
];

impl Setting {
    /// Parses a name and a value; the error says what there is.
    pub fn parse(name: &str, value: &str) -> Result<Setting, String> {
        let Some((_, values)) = NAMES.into_iter().find(|(known, _)| *known == name) else {
            let names = NAMES.map(|(name, _)| name).join(", ");
            return Err(format!("there is no mode '{name}'; use one of: {names}"));
        };
        Setting::read(name, value).ok_or_else(|| format!("'{value}' is no value of {name}; give {values}"))
    }

    fn read(name: &str, value: &str) -> Option<Setting> {
        Some(match name {
            "order" => Setting::Order(parsed(value)?),
            "schedule" => Setting::Schedule(parsed(value)?),
            "film" => Setting::Film(parsed(value)?),
            "threads" if value == "auto" => Setting::Threads(0),
            "threads" => Setting::Threads(parsed(value).filter(|n| (1..=1024).contains(n))?),
            "pin" => Setting::Pin(one_of(value, ["off", "on"])? == 1),
            "isa" if value == "auto" => Setting::Isa(None),
            "isa" => {
                let isa = Isa::available().find(|isa| isa.name() == value)?;
                choose_kernels(Some(isa)).ok()?;
                Setting::Isa(Some(isa))
            }
            "visibility" => Setting::Visibility(Visibility::ALL.into_iter().find(|v| v.name() == value)?),
            "kernel" => Setting::Kernel(parsed(value)?),
            "early-termination" => Setting::Early(parsed(value)?),
            "tile" => Setting::Tile(parsed(value).filter(|n| (1..=1024).contains(n))?),
            "exposure" => Setting::Exposure(parsed(value).filter(|stops: &f32| stops.abs() <= 50.0)?),
            "fov" => Setting::Fov(parsed(value).filter(|&degrees: &f32| degrees > 0.0 && degrees < 180.0)?),
            "camera" => Setting::Fly(one_of(value, ["orbit", "fly"])? == 1),
            "frame-time" => {
                let milliseconds = parsed(value).filter(|ms: &f64| (1.0..=10000.0).contains(ms))?;
                Setting::FrameTime(Duration::from_secs_f64(milliseconds * 1e-3))
            }
            "anti-aliasing" => Setting::AntiAliasing(one_of(value, ["off", "on"])? == 1),
            "effects" => Setting::Effects(parsed(value)?),
            "time" => Setting::Time(parsed(value).filter(|time: &f64| *time >= 0.0 && time.is_finite())?),
            "motion" => Setting::Play(one_of(value, ["stop", "play"])? == 1),
            "overlay" => Setting::Overlay(Overlay::ALL.into_iter().find(|overlay| overlay.name() == value)?),
            _ => return None,
        })
    }

    /// Changes what concerns the renderer; false if this setting does not, or nothing changes.
    pub fn apply(self, options: &mut RenderOptions) -> bool {
        match self {
            Setting::Order(order) => replaced(&mut options.order, order),
            Setting::Schedule(strategy) => replaced(&mut options.schedule.strategy, strategy),
            Setting::Film(film) => replaced(&mut options.schedule.film, film),
            Setting::Threads(threads) => replaced(&mut options.threads, (threads > 0).then_some(threads)),
            Setting::Pin(pin) => replaced(&mut options.pin, pin),
            Setting::Isa(isa) => replaced(&mut options.isa, isa),
            Setting::Visibility(visibility) => replaced(&mut options.visibility, visibility),
            Setting::Kernel(kernel) => replaced(&mut options.kernel, kernel),
            Setting::Early(early) => replaced(&mut options.early, early),
            Setting::Tile(tile) => replaced(&mut options.tile, tile),
            Setting::Effects(effects) => replaced(&mut options.effects, effects),
            Setting::Exposure(_)
            | Setting::Fov(_)
            | Setting::Fly(_)
            | Setting::FrameTime(_)
            | Setting::Overlay(_)
            | Setting::AntiAliasing(_)
            | Setting::Time(_)
            | Setting::Play(_) => false,
        }
    }
}

/// The modes that a key switches to their next value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// See [`Setting::Order`].
    Order,
    /// See [`Setting::Schedule`].
    Schedule,
    /// See [`Setting::Film`].
    Film,
    /// See [`Setting::Threads`].
    Threads,
    /// See [`Setting::Isa`].
    Isa,
    /// See [`Setting::Visibility`].
    Visibility,
    /// See [`Setting::Kernel`].
    Kernel,
    /// See [`Setting::Early`].
    Early,
    /// See [`Setting::Tile`].
    Tile,
    /// See [`Setting::Pin`].
    Pin,
    /// See [`Setting::Fly`].
    Camera,
    /// See [`Setting::Overlay`].
    Overlay,
    /// See [`Setting::AntiAliasing`].
    AntiAliasing,
    /// See [`Setting::Effects`].
    Effects,
    /// See [`Setting::Play`].
    Play,
}

/// What is set, as far as the next value of a mode depends on it.
#[derive(Clone, Copy, Debug)]
pub struct Now<'a> {
    /// How to render.
    pub options: &'a RenderOptions,
    /// See [`Setting::Fly`].
    pub fly: bool,
    /// See [`Setting::Overlay`].
    pub overlay: Overlay,
    /// See [`Setting::AntiAliasing`].
    pub antialiasing: bool,
    /// See [`Setting::Play`].
    pub playing: bool,
    /// Workers that are worth having.
    pub cores: usize,
    /// Effects that the scene calls for.
    pub called: EffectSet,
}

impl Mode {
    /// All of them.
    pub const ALL: [Mode; 15] = [
        Mode::Order,
        Mode::Schedule,
        Mode::Film,
        Mode::Threads,
        Mode::Isa,
        Mode::Visibility,
        Mode::Kernel,
        Mode::Early,
        Mode::Tile,
        Mode::Pin,
        Mode::Camera,
        Mode::Overlay,
        Mode::AntiAliasing,
        Mode::Effects,
        Mode::Play,
    ];

    /// The value after the one that is set.
    pub fn next(self, now: &Now<'_>) -> Setting {
        let Now { options, fly, overlay, antialiasing, playing, cores, called } = *now;
        let early: Vec<EarlyTermination> = [
            "none",
            "pet-bound",
            "pet-bound,set",
            "pet-bound,set,occ",
            "pet-bound,pet-seed,set,occ",
            "pet-bound,set,occ,area",
        ]
        .iter()
        .filter_map(|name| name.parse().ok())
        .collect();
        match self {
            Mode::Order => Setting::Order(after(&Order::ALL, options.order)),
            Mode::Schedule => Setting::Schedule(after(&Strategy::ALL, options.schedule.strategy)),
            Mode::Film => Setting::Film(after(&FilmMode::ALL, options.schedule.film)),
            Mode::Threads => {
                let counts: Vec<usize> = (0..=cores).collect();
                Setting::Threads(after(&counts, options.threads.unwrap_or(0)))
            }
            Mode::Isa => {
                let isas: Vec<Option<Isa>> =
                    std::iter::once(None).chain(Isa::available().map(Some)).collect();
                Setting::Isa(after(&isas, options.isa))
            }
            Mode::Visibility => Setting::Visibility(after(&Visibility::ALL, options.visibility)),
            Mode::Kernel => Setting::Kernel(after(&KernelChoice::ALL, options.kernel)),
            Mode::Early => Setting::Early(after(&early, options.early)),
            Mode::Tile => Setting::Tile(after(&[16, 32, 64, 128, 256], options.tile)),
            Mode::Pin => Setting::Pin(!options.pin),
            Mode::Camera => Setting::Fly(!fly),
            Mode::Overlay => Setting::Overlay(after(&Overlay::ALL, overlay)),
            Mode::AntiAliasing => Setting::AntiAliasing(!antialiasing),
            Mode::Effects => {
                let without = called.iter().map(|effect| EffectChoice::Without(EffectSet::of(&[effect])));
                let all: Vec<_> =
                    [EffectChoice::Auto, EffectChoice::All].into_iter().chain(without).collect();
                Setting::Effects(after(&all, options.effects))
            }
            Mode::Play => Setting::Play(!playing),
        }
    }
}

/// The value behind `now`, or the first.
fn after<T: Copy + PartialEq>(all: &[T], now: T) -> T {
    let place = all.iter().position(|&value| value == now).map_or(0, |place| place + 1);
    all[place % all.len()]
}

fn parsed<T: FromStr>(value: &str) -> Option<T> {
    value.parse().ok()
}

fn one_of<const N: usize>(value: &str, names: [&str; N]) -> Option<usize> {
    names.into_iter().position(|name| name == value)
}

fn replaced<T: PartialEq>(old: &mut T, new: T) -> bool {
    std::mem::replace(old, new) != *old
}

/// The modes of a renderer, in one line.
pub(super) fn described(options: &RenderOptions) -> String {
    let text = |value: Option<String>| value.unwrap_or_else(|| "auto".into());
    let show = |value: &dyn Display| value.to_string();
    format!(
        "{} {} {} tile {} threads {} {} {} {} {} effects {}",
        options.order,
        options.schedule.strategy,
        options.schedule.film,
        options.tile,
        text(options.threads.map(|n| show(&n))),
        text(options.isa.map(|isa| show(&isa))),
        options.visibility,
        options.kernel,
        options.early,
        options.effects
    )
}
