//! The time of a scene that moves, in the user's hands.

use crate::scene::Motion;

/// A moment of the motion, which may pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clock {
    /// Seconds from the beginning.
    pub time: f64,
    /// It passes.
    pub playing: bool,
    length: f64,
    rate: f64,
}

impl Clock {
    /// At the beginning, stopped. Without motion it stays there.
    pub fn new(motion: Option<&Motion>) -> Clock {
        motion.map_or_else(Clock::default, |motion| Clock {
            length: motion.length(),
            rate: motion.rate(),
            ..Clock::default()
        })
    }

    /// Seconds from the beginning to the end; 0 if nothing moves.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Lets it pass or stops it.
    pub fn play(&mut self, playing: bool) {
        self.playing = playing && self.length > 0.0;
    }

    /// Goes to a time, at most the end.
    pub fn set(&mut self, time: f64) {
        self.time = time.clamp(0.0, self.length);
    }

    /// So many seconds have passed. After the end it begins anew.
    pub fn advance(&mut self, seconds: f64) {
        if self.playing {
            let time = self.time + seconds;
            self.time = if time > self.length { time % self.length } else { time };
        }
    }

    /// Stops, and goes on to the next whole moment, or back; from the last to the first.
    pub fn step(&mut self, ahead: bool) {
        if self.length == 0.0 {
            return;
        }
        self.playing = false;
        // A thousandth of a moment is rounding.
        let (now, last) = (self.time * self.rate, (self.length * self.rate + 1.0e-3).floor());
        let next = if ahead { (now + 1.0e-3).floor() + 1.0 } else { (now - 1.0e-3).ceil() - 1.0 };
        self.time = if next > last {
            0.0
        } else if next < 0.0 {
            last / self.rate
        } else {
            next / self.rate
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four moments in one and a half seconds.
    const CLOCK: Clock = Clock { time: 0.0, playing: true, length: 1.5, rate: 2.0 };

    #[test]
    fn time_passes_while_it_plays_and_begins_anew() {
        let mut clock = CLOCK;
        let mut passed = |seconds| {
            clock.advance(seconds);
            clock.time
        };
        assert_eq!([passed(1.0), passed(0.5), passed(0.25), passed(3.5)], [1.0, 1.5, 0.25, 0.75]);
        clock.play(false);
        clock.advance(1.0);
        assert_eq!(clock.time, 0.75);
        clock.set(9.0);
        assert_eq!(clock.time, 1.5);
    }

    #[test]
    fn steps_go_from_moment_to_moment_and_around() {
        let steps = |from: f64, ahead: bool| {
            let mut clock = Clock { time: from, ..CLOCK };
            let times = [(); 5].map(|()| {
                clock.step(ahead);
                clock.time
            });
            assert!(!clock.playing);
            times
        };
        assert_eq!(steps(0.0, true), [0.5, 1.0, 1.5, 0.0, 0.5]);
        assert_eq!(steps(0.7, true), [1.0, 1.5, 0.0, 0.5, 1.0]);
        assert_eq!(steps(0.7, false), [0.5, 0.0, 1.5, 1.0, 0.5]);
    }

    #[test]
    fn nothing_passes_where_nothing_moves() {
        let mut clock = Clock::new(None);
        clock.play(true);
        clock.advance(1.0);
        clock.step(true);
        clock.set(1.0);
        assert_eq!(clock, Clock::default());
    }
}
