//! Sets whose rows can be generated separately, so that several processes can each generate their own rows.
//!
//! **Statement.** Every row of such a set takes the same number of draws from one stream, possibly none. So row i is a function
//! of the request, of i, and of the draws from `i w` to `(i + 1) w`, where w is that number. `ChaCha` can skip draws in O(1).
//! No step after the draws changes the order of the rows or removes any.
//!
//! The other kinds draw by rejection (`ball`, `sphere`, `line`, `shells`), or are meshes (the f-spaced kinds).

use std::ops::Range;

use glam::{DVec2, DVec3};
use septet_geometry::point::{Point, dist2};

use super::check;
use super::draw::{Draw, Purpose};
use super::kind::Kind;
use super::request::{GenerateError, Request};
use crate::model::{HigherPoints, Points};
use septet_geometry::higher::VecN;

/// A set whose rows can be generated separately.
#[derive(Clone, Debug)]
pub struct SeparateRows(Typed);

/// The rows by their dimension.
#[derive(Clone, Debug)]
enum Typed {
    Plane(Rows<DVec2>),
    Space(Rows<DVec3>),
    Four(Rows<VecN<4>>),
    Five(Rows<VecN<5>>),
    Six(Rows<VecN<6>>),
}

impl SeparateRows {
    /// Returns the set of a request, or `None` if the rows of its kind cannot be generated separately. For
    /// [`Kind::Poisson`], the call draws the number of points in O(n) steps.
    ///
    /// # Errors
    /// See [`super::generate`].
    pub fn of(request: &Request) -> Result<Option<Self>, GenerateError> {
        check::request(request)?;
        Ok(match request.dimension {
            2 => Rows::of(request).map(Typed::Plane),
            3 => Rows::of(request).map(Typed::Space),
            4 => Rows::of(request).map(Typed::Four),
            5 => Rows::of(request).map(Typed::Five),
            _ => Rows::of(request).map(Typed::Six),
        }
        .map(SeparateRows))
    }

    /// Returns the number of points of the set.
    pub fn count(&self) -> u64 {
        match &self.0 {
            Typed::Plane(rows) => rows.count,
            Typed::Space(rows) => rows.count,
            Typed::Four(rows) => rows.count,
            Typed::Five(rows) => rows.count,
            Typed::Six(rows) => rows.count,
        }
    }

    /// Returns the points of some rows. They are the points of these rows in the set that [`super::generate`] returns. Rows
    /// from [`SeparateRows::count`] on do not exist, and are omitted.
    pub fn points(&self, rows: Range<u64>) -> Points {
        match &self.0 {
            Typed::Plane(all) => Points::Plane(all.range(rows)),
            Typed::Space(all) => Points::Space(all.range(rows)),
            Typed::Four(all) => Points::Higher(HigherPoints::Four(all.range(rows))),
            Typed::Five(all) => Points::Higher(HigherPoints::Five(all.range(rows))),
            Typed::Six(all) => Points::Higher(HigherPoints::Six(all.range(rows))),
        }
    }

    /// Returns the notes of the set, as in [`super::Generated::notes`].
    pub fn notes(&self, request: &Request) -> Vec<String> {
        check::count(request, self.count()).into_iter().collect()
    }
}

/// The rows of a set.
#[derive(Clone, Debug)]
pub(super) struct Rows<P> {
    /// The number of rows.
    pub count: u64,
    seed: u64,
    rule: Rule<P>,
}

/// The rule by which a row follows from its number and its draws.
#[derive(Clone, Debug)]
enum Rule<P> {
    /// A point of the unit square or cube.
    Uniform,
    /// A point of a slab of thickness 1/1000.
    Slab,
    /// A point of a lattice.
    Grid { side: u64, unit: f64 },
    /// A point of a lattice with an even sum of coordinates.
    Even { side: u64, unit: f64 },
    /// A point in the middle half of a cell of a grid.
    Jittered { side: u64 },
    /// A point of one of the clusters, in turn.
    Clusters(Vec<P>),
    /// A point of the moment curve.
    Moment { unit: f64 },
}

impl<P: Point> Rows<P> {
    /// Returns the rows of a checked request, or `None` if they cannot be generated separately.
    pub fn of(request: &Request) -> Option<Self> {
        let Request { kind, n, seed, .. } = *request;
        let power = |side: u64| side.pow(P::DIM as u32);
        let (count, rule) = match kind {
            Kind::Uniform => (n, Rule::Uniform),
            Kind::Poisson => (Draw::new(seed, Purpose::Count).poisson(n), Rule::Uniform),
            Kind::Slab => (n, Rule::Slab),
            Kind::Grid => {
                let side = nearest_side(n, power);
                let unit = 1.0 / side.saturating_sub(1).next_power_of_two() as f64;
                (power(side), Rule::Grid { side, unit })
            }
            Kind::Fcc => {
                let per_cell = 1 << (P::DIM - 1);
                let side = 2 * nearest_side(n, |cells| per_cell * power(cells));
                (power(side) / 2, Rule::Even { side, unit: 1.0 / side.next_power_of_two() as f64 })
            }
            Kind::Jittered => {
                let side = nearest_side(n, power);
                (power(side), Rule::Jittered { side })
            }
            Kind::Clusters => (n, Rule::Clusters(centres(seed))),
            Kind::MomentCurve => {
                (n, Rule::Moment { unit: 1.0 / n.saturating_sub(1).next_power_of_two() as f64 })
            }
            Kind::Ball
            | Kind::Sphere
            | Kind::Line
            | Kind::Body
            | Kind::Shells
            | Kind::WellSpaced
            | Kind::GradedPoint
            | Kind::GradedLine => return None,
        };
        Some(Rows { count, seed, rule })
    }

    /// Generates some rows.
    pub fn range(&self, rows: Range<u64>) -> Vec<P> {
        let rows = rows.start.min(self.count)..rows.end.min(self.count);
        let mut draw = Draw::new(self.seed, Purpose::Points);
        draw.skip(rows.start * self.rule.draws());
        rows.map(|row| self.rule.row(row, &mut draw)).collect()
    }
}

impl<P: Point> Rule<P> {
    /// Returns the number of draws of each row.
    fn draws(&self) -> u64 {
        let points = match self {
            Rule::Uniform | Rule::Slab | Rule::Jittered { .. } => 1,
            Rule::Clusters(_) => Draw::BELL_POINTS,
            Rule::Grid { .. } | Rule::Even { .. } | Rule::Moment { .. } => 0,
        };
        points * P::DIM as u64
    }

    /// Generates a row from its own draws.
    fn row(&self, row: u64, draw: &mut Draw) -> P {
        match self {
            Rule::Uniform => draw.point(),
            Rule::Slab => {
                let mut p: P = draw.point();
                p.set_coord(P::DIM - 1, p.coord(P::DIM - 1) / 1000.0);
                p
            }
            Rule::Grid { side, unit } => lattice::<P>(row, *side) * *unit,
            Rule::Even { side, unit } => even::<P>(row, *side) * *unit,
            Rule::Jittered { side } => {
                let inside = draw.point::<P>() * 0.5;
                (lattice::<P>(row, *side) + P::splat(0.25) + inside) / *side as f64
            }
            Rule::Clusters(centres) => {
                let which = row as usize % centres.len();
                centres[which] + draw.bell::<P>() * (0.02 / (1u64 << which) as f64)
            }
            Rule::Moment { unit } => {
                let t = row as f64 * unit;
                let (mut p, mut power) = (P::default(), t);
                for axis in 0..P::DIM {
                    p.set_coord(axis, power);
                    power *= t;
                }
                p
            }
        }
    }
}

/// Returns the side `k` whose count is closest to `n`. It is at least 1, unless `n` is 0.
fn nearest_side(n: u64, count: impl Fn(u64) -> u64) -> u64 {
    let mut side = 0;
    while count(side) < n {
        side += 1;
    }
    if side > 1 && n - count(side - 1) < count(side) - n { side - 1 } else { side }
}

/// Returns an integer point of the lattice `0..side` of every axis. The last axis varies fastest.
fn lattice<P: Point>(mut row: u64, side: u64) -> P {
    let mut p = P::default();
    for axis in (0..P::DIM).rev() {
        p.set_coord(axis, (row % side) as f64);
        row /= side;
    }
    p
}

/// Returns an integer point of the lattice among those with an even sum of coordinates. The side is even, so half of the
/// points of each line along the last axis have an even sum.
fn even<P: Point>(row: u64, side: u64) -> P {
    let half = side / 2;
    let mut p = lattice::<P>(row / half * side, side);
    let others: u64 = (0..P::DIM - 1).map(|axis| p.coord(axis) as u64).sum();
    p.set_coord(P::DIM - 1, (2 * (row % half) + others % 2) as f64);
    p
}

/// Draws the centres of ten clusters. Cluster `i` has standard deviation `0.02 / 2^i` and a radius of six deviations. Each
/// centre is the farthest of 64 random places from the previous centres.
fn centres<P: Point>(seed: u64) -> Vec<P> {
    const CLUSTERS: usize = 10;
    let mut places = Draw::new(seed, Purpose::Centres);
    let mut centres: Vec<P> = Vec::new();
    while centres.len() < CLUSTERS {
        let mut farthest = (-1.0, P::default());
        for _ in 0..64 {
            let place = places.point::<P>() * 0.75 + P::splat(0.125);
            let distance = centres.iter().map(|&c| dist2(c, place)).fold(f64::MAX, f64::min);
            if distance > farthest.0 {
                farthest = (distance, place);
            }
        }
        centres.push(farthest.1);
    }
    centres
}
