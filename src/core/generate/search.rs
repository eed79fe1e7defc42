//! The size function whose f-spaced set has the requested number of points.
//!
//! **Statement.** A complete f-spaced set has about `sum over faces F of c_k * integral of f^-k over F` points. Here
//! `k` is the dimension of `F`, and the constants `c_k` were measured. Bisection inverts this estimate. The measured
//! size of a first, smaller set with the same slope corrects it. A set whose size is within 5 % of the request is
//! accepted. After [`TRIALS`] trials, the closest set is accepted.
//!
//! **Work.** Each trial generates a set of n points.
//!
//! **Departures.** With a fixed slope L, a set graded to a point has only O(L^-d log(1/least)) points. For larger
//! requests the slope is reduced. Then f is still L-Lipschitz. The result reports the slope that was used.

use septet_geometry::point::Point;

use super::faces::CubeFace;
use super::kind::Kind;
use super::request::{GRADED_LIPSCHITZ, GenerateError, GenerateProgress, Request};
use super::sizing::{Centre, Sizing};
use super::spaced;
use super::unit::Unit;

/// The accepted relative difference from the requested number.
const TOLERANCE: f64 = 0.05;

/// The largest number of trials, each with a set of full size.
const TRIALS: usize = 4;

/// The number of points per `f^k` on faces of dimension `k`, in the plane and in space. Below the full dimension, it is
/// the contribution of the boundary to the count.
const DENSITY: [[f64; 4]; 2] = [[1.0, 0.21, 0.711, 0.0], [1.0, -0.085, 0.332, 0.741]];

/// The number of points of the set that calibrates the estimate for larger ones.
const PILOT: f64 = 20_000.0;

/// An f-spaced set with its size function.
pub(super) struct SpacedSet<P> {
    /// The points.
    pub points: Vec<P>,
    /// The size function used.
    pub sizing: Sizing,
    /// Notes for the reader of the report.
    pub notes: Vec<String>,
}

/// Builds the f-spaced set of a checked request.
pub(super) fn spaced_set<P: Unit>(
    request: &Request,
    progress: &mut GenerateProgress,
) -> Result<SpacedSet<P>, GenerateError> {
    let family = Family::of(request);
    let wanted = request.n as f64;
    let first = family.sizing::<P>(wanted.max(1.0), None);
    let mut set = SpacedSet { points: Vec::new(), sizing: first, notes: Vec::new() };
    if request.n == 0 {
        return Ok(set);
    }
    let mut factor = 1.0;
    let mut best = f64::MAX;
    if wanted > 2.0 * PILOT {
        let pilot = family.sizing::<P>(PILOT, Some(first.slope));
        let points: Vec<P> = spaced::build(pilot, request.seed, &mut |_| {})?;
        factor = points.len() as f64 / estimate::<P>(&pilot);
    }
    for _ in 0..TRIALS {
        let sizing = family.sizing::<P>(wanted / factor, None);
        let mut report = |done: u64| progress(request.kind.name(), done.min(request.n), request.n);
        let points: Vec<P> = spaced::build(sizing, request.seed, &mut report)?;
        let made = points.len() as f64;
        factor = made / estimate::<P>(&sizing);
        let error = (made / wanted - 1.0).abs();
        if error < best {
            best = error;
            set.points = points;
            set.sizing = sizing;
        }
        if best <= TOLERANCE {
            break;
        }
    }
    if best > TOLERANCE {
        let (made, asked) = (set.points.len(), request.n);
        set.notes.push(format!("{made} points instead of {asked}: no size function gives a closer number"));
    }
    if set.sizing.slope < family.slope {
        let (used, asked) = (set.sizing.slope, family.slope);
        set.notes
            .push(format!("the size function has slope {used:.4}, because slope {asked} gives fewer points"));
    }
    Ok(set)
}

/// The size functions of a kind.
struct Family {
    centre: Centre,
    slope: f64,
    /// The smallest `least / slope` of the family. It limits how sharply sizes decrease.
    sharpest: f64,
}

impl Family {
    fn of(request: &Request) -> Self {
        let slope = request.lipschitz.unwrap_or(GRADED_LIPSCHITZ);
        match request.kind {
            Kind::GradedPoint => Family { centre: Centre::Point, slope, sharpest: 0.001 },
            Kind::GradedLine => Family { centre: Centre::Line, slope, sharpest: 0.0001 },
            _ => Family { centre: Centre::Point, slope: 0.0, sharpest: 0.0 },
        }
    }

    /// Returns the size function with an estimate of `wanted` points. Uses the given slope, if there is one.
    fn sizing<P: Point>(&self, wanted: f64, slope: Option<f64>) -> Sizing {
        let centre = self.centre;
        if self.slope == 0.0 {
            let at = |least| Sizing { centre, slope: 0.0, least };
            return invert::<P>(wanted, 1e-5, 1.0, at);
        }
        let slope = slope.unwrap_or(self.slope);
        let at = |offset: f64| Sizing { centre, slope, least: slope * offset };
        let sharpest = at(self.sharpest);
        if estimate::<P>(&sharpest) >= wanted {
            // Sizes at the corners must not exceed the side, 1.
            let corner = sharpest.distance(&P::splat(0.0));
            return invert::<P>(wanted, self.sharpest, 1.0 / slope - corner, at);
        }
        let flatter = |slope: f64| Sizing { centre, slope, least: slope * self.sharpest };
        invert::<P>(wanted, 1e-5, slope, flatter)
    }
}

/// Returns the member of an increasing family of size functions that has an estimate of `wanted` points. Bisects the
/// parameter geometrically.
fn invert<P: Point>(wanted: f64, low: f64, high: f64, at: impl Fn(f64) -> Sizing) -> Sizing {
    let (mut low, mut high) = (low, high);
    for _ in 0..40 {
        let middle = (low * high).sqrt();
        if estimate::<P>(&at(middle)) > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    at(high)
}

/// Estimates the number of points.
pub(super) fn estimate<P: Point>(sizing: &Sizing) -> f64 {
    let mut sum = 0.0;
    for (k, density) in DENSITY[P::DIM - 2].iter().enumerate().take(P::DIM + 1) {
        for face in CubeFace::<P>::all(k) {
            if sizing.slope == 0.0 {
                sum += density / power(sizing.least, k);
                continue;
            }
            let step = |p: &P| 0.5 * sizing.at(p) / sizing.slope;
            face.tile(step, |middle, side| sum += density * power(side / sizing.at(&middle), k));
        }
    }
    sum
}

fn power(x: f64, k: usize) -> f64 {
    (0..k).fold(1.0, |product, _| product * x)
}
