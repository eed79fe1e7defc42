//! Random draws that are the same on every platform: `ChaCha` and the four arithmetic operations.
//!
//! **Statement.** Every draw is a function of (seed, purpose, index of the draw). No logarithm or other library
//! function is used. Exponential variates come from comparisons only (von Neumann, "Various techniques used in
//! connection with random digits", 1951). Poisson variates count exponential gaps. Bell-shaped offsets are sums of
//! twelve uniform variates.
//!
//! **Work.** O(1) expected per variate. A Poisson variate of mean `n` costs O(n).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use septet_geometry::point::Point;

/// The use of a stream. Streams of different purposes never overlap.
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    /// Coordinates.
    Points = 1,
    /// The number of points of a Poisson process.
    Count = 2,
    /// Centres of clusters.
    Centres = 3,
}

/// A stream of draws.
pub(super) struct Draw(ChaCha8Rng);

impl Draw {
    /// Starts the stream of a seed and a purpose.
    pub fn new(seed: u64, purpose: Purpose) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(purpose as u64);
        Draw(rng)
    }

    /// The number of points that [`Draw::bell`] draws.
    pub const BELL_POINTS: u64 = 12;

    /// Skips draws of 64 bits, in O(1).
    pub fn skip(&mut self, draws: u64) {
        // A draw takes two words of the stream.
        self.0.set_word_pos(self.0.get_word_pos() + 2 * u128::from(draws));
    }

    /// Draws 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Draws a uniform multiple of 2^-53 from `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Draws a uniform point of the unit square or cube.
    pub fn point<P: Point>(&mut self) -> P {
        let mut p = P::default();
        for i in 0..P::DIM {
            p.set_coord(i, self.unit());
        }
        p
    }

    /// Draws a uniform point of the ball of radius 1 about the origin, by rejection.
    pub fn in_ball<P: Point>(&mut self) -> P {
        loop {
            let p = self.point::<P>() * 2.0 - P::splat(1.0);
            if p.norm2() <= 1.0 {
                return p;
            }
        }
    }

    /// Draws a uniform point of the sphere of radius 1 about the origin, by rejection from the ball. No sine is needed.
    pub fn direction<P: Point>(&mut self) -> P {
        loop {
            let p: P = self.in_ball();
            let length = p.norm2().sqrt();
            // Very short vectors have too few bits for a direction.
            if length > 1.0 / 64.0 {
                return p / length;
            }
        }
    }

    /// Draws a bell-shaped vector: every coordinate has mean 0, variance 1 and absolute value at most 6.
    pub fn bell<P: Point>(&mut self) -> P {
        let mut sum = P::splat(-6.0);
        for _ in 0..Draw::BELL_POINTS {
            sum = sum + self.point();
        }
        sum
    }

    /// Draws an exponential variate with mean 1. Uniform numbers are drawn as long as they decrease. The length of such
    /// a run is odd with probability `exp(-u)`, where `u` is its first number. A run of odd length ends the draw, and
    /// each run of even length adds 1.
    pub fn exponential(&mut self) -> f64 {
        let mut whole = 0.0;
        loop {
            let first = self.unit();
            let mut last = first;
            let mut odd = true;
            loop {
                let next = self.unit();
                if next >= last {
                    break;
                }
                last = next;
                odd = !odd;
            }
            if odd {
                return whole + first;
            }
            whole += 1.0;
        }
    }

    /// Draws a Poisson variate: the number of exponential gaps that fit into `mean`.
    pub fn poisson(&mut self, mean: u64) -> u64 {
        let mut count = 0;
        let mut time = self.exponential();
        while time <= mean as f64 {
            count += 1;
            time += self.exponential();
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use septet_geometry::point::Vector;

    #[test]
    fn variates_have_their_moments() {
        let mut draw = Draw::new(5, Purpose::Points);
        let n = 100_000;
        let values: Vec<f64> = (0..n).map(|_| draw.exponential()).collect();
        let mean = values.iter().sum::<f64>() / f64::from(n);
        let square = values.iter().map(|x| x * x).sum::<f64>() / f64::from(n);
        assert!((mean - 1.0).abs() < 0.02 && (square - 2.0).abs() < 0.1);
        let above: Vec<&f64> = values.iter().filter(|&&x| x > 2.0).collect();
        assert!((above.len() as f64 / f64::from(n) - 0.135_335).abs() < 0.005);
        let counts: Vec<f64> = (0..2_000).map(|_| draw.poisson(100) as f64).collect();
        let mean = counts.iter().sum::<f64>() / 2_000.0;
        let variance = counts.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 2_000.0;
        assert!((mean - 100.0).abs() < 1.0 && (variance - 100.0).abs() < 12.0);
        let bell: f64 = (0..n).map(|_| draw.bell::<DVec3>().norm2()).sum::<f64>() / f64::from(n);
        assert!((bell - 3.0).abs() < 0.05);
    }

    #[test]
    fn streams_differ() {
        let mut all: Vec<u64> = vec![
            Draw::new(1, Purpose::Points).bits(),
            Draw::new(2, Purpose::Points).bits(),
            Draw::new(1, Purpose::Count).bits(),
            Draw::new(1, Purpose::Centres).bits(),
        ];
        all.dedup();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 4);
    }
}
