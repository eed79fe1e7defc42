//! The picture of a run: sampled points with their owners and the proofs of their stars, and the separators of the tree.
//! The shares of the ranks contain its parts.
//!
//! A hash of the coordinates selects the points, so the sample does not depend on the number of workers. Coordinates are
//! rounded to a millionth of the set's extent, which suffices for a picture.

use std::collections::BTreeMap;

use serde::Serialize;

use septet_geometry::hash::hash_of_place;
use septet_geometry::point::Point;
use septet_geometry::range::scale;
use septet_geometry::separator::{Separator, Surface};
use septet_protocol::ids::NodeId;
use septet_protocol::message::ViewPart;

pub use crate::spec::MOST_POINTS;

/// Largest number of separators shown. Upper levels come first.
pub const MOST_SEPARATORS: usize = 4095;

/// Largest number of (point, leaf) pairs of ghosts shown.
pub const MOST_GHOSTS: usize = 80_000;

/// The sampled points, one entry each, and the tree.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct View {
    /// Number of points of the whole set.
    pub of: u64,
    /// Number of points shown.
    pub points: u64,
    /// Smallest coordinates of the set.
    pub low: Vec<f64>,
    /// Largest coordinates of the set.
    pub high: Vec<f64>,
    /// Node ids of the leaves that occur below.
    pub leaves: Vec<u64>,
    /// Coordinates, point by point.
    pub positions: Vec<f64>,
    /// The owner of each point.
    pub owner: Vec<u32>,
    /// The leaf that owns each point: a position in `leaves`.
    pub leaf: Vec<u32>,
    /// Bit `l` is set if the ball of the point meets the separator of its ancestor at level `l`.
    pub crossing: Vec<u64>,
    /// 1 if splaying changed the star, 2 if a ball of the known radius proves it, else 0.
    pub flags: Vec<u64>,
    /// Points of which another leaf holds a ghost, as positions in this sample.
    pub ghost: Vec<u32>,
    /// The leaf that holds each ghost: a position in `leaves`.
    pub ghost_leaf: Vec<u32>,
    /// Number of ghosts omitted.
    pub ghosts_omitted: u64,
    /// Separators, by node.
    pub separators: Vec<SeparatorView>,
    /// Number of separators omitted, which are at deeper levels.
    pub separators_omitted: u64,
}

/// One separator, in the coordinates of the input.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SeparatorView {
    /// Path number of the node that it splits.
    pub node: u64,
    /// Levels below the root.
    pub level: u32,
    /// `sphere` or `plane`.
    pub kind: &'static str,
    /// Centre of a sphere, or unit normal of a plane.
    pub vector: Vec<f64>,
    /// Radius of a sphere, or offset of a plane along its normal.
    pub number: f64,
    /// The side of the interior child: inside the sphere (`ball`), outside (`around`), or `below` the plane.
    pub interior: &'static str,
    /// Smallest coordinates of the node's points.
    pub low: Vec<f64>,
    /// Largest coordinates of the node's points.
    pub high: Vec<f64>,
}

/// The parts of the picture that have arrived, in the machine's coordinates.
#[derive(Clone, Debug, Default)]
pub(crate) struct Album {
    points: Vec<Entry>,
    /// Id and leaf.
    ghosts: Vec<(u64, u64)>,
    splits: BTreeMap<u64, (Vec<f64>, [Vec<f64>; 2])>,
}

#[derive(Clone, Debug)]
struct Entry {
    hash: u64,
    id: u64,
    position: Vec<f64>,
    owner: u32,
    leaf: u64,
    crossing: u64,
    flags: u64,
}

fn coordinates<P: Point>(x: P) -> Vec<f64> {
    (0..P::DIM).map(|i| x.coord(i)).collect()
}

fn point<P: Point>(coordinates: &[f64]) -> P {
    let mut x = P::splat(0.0);
    for (i, &c) in coordinates.iter().enumerate() {
        x.set_coord(i, c);
    }
    x
}

impl Album {
    /// Collects the parts of all workers.
    pub(crate) fn of<P: Point>(parts: &[ViewPart<P>]) -> Self {
        let mut album = Album::default();
        for part in parts {
            album.add(part);
        }
        album
    }

    /// Adds a worker's part, whose columns have matching lengths.
    fn add<P: Point>(&mut self, part: &ViewPart<P>) {
        for (i, &position) in part.points.positions.iter().enumerate() {
            self.points.push(Entry {
                hash: hash_of_place(position),
                id: part.points.ids[i],
                position: coordinates(position),
                owner: part.points.owners[i],
                leaf: part.leaves[i],
                crossing: part.crossing[i],
                flags: part.flags[i],
            });
        }
        self.ghosts.extend(part.ghosts.iter().copied().zip(part.ghost_leaves.iter().copied()));
        for (i, &node) in part.nodes.iter().enumerate() {
            let count = Separator::<P>::WORDS;
            let words = part.separators[i * count..][..count].to_vec();
            let corners = [part.boxes[2 * i], part.boxes[2 * i + 1]].map(coordinates);
            self.splits.insert(node, (words, corners));
        }
    }

    /// Returns the picture, with at most `most` points. Coordinates are divided by `2^exponent`, which gives the input
    /// coordinates.
    pub(crate) fn view<P: Point>(mut self, population: u64, most: u32, exponent: i32) -> View {
        self.points.sort_unstable_by_key(|e| (e.hash, e.id));
        self.points.truncate(most as usize);
        let frame = Frame::<P>::of(&self, exponent);
        let mut view = View {
            of: population,
            points: self.points.len() as u64,
            low: frame.round(&frame.low),
            high: frame.round(&frame.high),
            ..View::default()
        };
        let mut leaves: BTreeMap<u64, u32> = self.points.iter().map(|e| (e.leaf, 0)).collect();
        leaves.extend(self.ghosts.iter().map(|g| (g.1, 0)));
        for (number, place) in (0u32..).zip(leaves.values_mut()) {
            *place = number;
        }
        for entry in &self.points {
            view.positions.extend(frame.shown(&entry.position));
            view.owner.push(entry.owner);
            view.leaf.push(leaves[&entry.leaf]);
            view.crossing.push(entry.crossing);
            view.flags.push(entry.flags);
        }
        self.show_ghosts(&leaves, &mut view);
        view.leaves = leaves.into_keys().collect();
        let separators = self.splits.iter().take(MOST_SEPARATORS);
        view.separators = separators.filter_map(|(&n, (w, b))| frame.separator(n, w, b)).collect();
        view.separators_omitted = (self.splits.len() - view.separators.len()) as u64;
        view
    }

    fn show_ghosts(&self, leaves: &BTreeMap<u64, u32>, view: &mut View) {
        let places: BTreeMap<u64, u32> = self.points.iter().map(|e| e.id).zip(0..).collect();
        let known = |&(id, leaf): &(u64, u64)| Some((*places.get(&id)?, leaves[&leaf]));
        let mut ghosts: Vec<(u32, u32)> = self.ghosts.iter().filter_map(known).collect();
        ghosts.sort_unstable();
        view.ghosts_omitted = ghosts.len().saturating_sub(MOST_GHOSTS) as u64;
        ghosts.truncate(MOST_GHOSTS);
        (view.ghost, view.ghost_leaf) = ghosts.into_iter().unzip();
    }
}

/// The number of decimal places to which the numbers of a picture are rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Digits(i32);

impl Digits {
    /// Selects rounding to `digits` digits below the leading digit of the extent.
    pub(crate) fn of(extent: f64, digits: i32) -> Self {
        Digits(if extent > 0.0 { digits - extent.log10().floor() as i32 } else { 17 })
    }

    /// Returns the rounded value, or the value itself if its decimal form cannot be parsed.
    pub(crate) fn round(self, value: f64) -> f64 {
        match usize::try_from(self.0) {
            Ok(digits) if digits <= 17 => format!("{value:.digits$}").parse().unwrap_or(value),
            Ok(_) => format!("{value:.8e}").parse().unwrap_or(value),
            Err(_) => format!("{value:.0}").parse().unwrap_or(value),
        }
    }
}

/// The map from the machine's coordinates to the rounded coordinates of the input.
struct Frame<P> {
    exponent: i32,
    low: Vec<f64>,
    high: Vec<f64>,
    digits: Digits,
    space: std::marker::PhantomData<P>,
}

impl<P: Point> Frame<P> {
    fn of(album: &Album, exponent: i32) -> Self {
        let back = |c: &[f64]| coordinates(scale(point::<P>(c), -exponent));
        let whole = album.splits.get(&NodeId::ROOT.0).map(|(_, b)| b.clone());
        let mut corners = album.points.iter().map(|e| &e.position).chain(whole.iter().flatten());
        let first = corners.next().cloned().unwrap_or_else(|| vec![0.0; P::DIM]);
        let (low, high) = corners.fold((first.clone(), first), |(mut low, mut high), c| {
            for i in 0..P::DIM {
                low[i] = low[i].min(c[i]);
                high[i] = high[i].max(c[i]);
            }
            (low, high)
        });
        let (low, high) = (back(&low), back(&high));
        let extent = low.iter().zip(&high).map(|(l, h)| h - l).fold(0.0, f64::max);
        let digits = Digits::of(extent, 6);
        Frame { exponent, low, high, digits, space: std::marker::PhantomData }
    }

    /// Rounds to a millionth of the extent.
    fn round(&self, values: &[f64]) -> Vec<f64> {
        values.iter().map(|&v| self.digits.round(v)).collect()
    }

    fn shown(&self, machine: &[f64]) -> Vec<f64> {
        self.round(&coordinates(scale(point::<P>(machine), -self.exponent)))
    }

    fn separator(&self, node: u64, words: &[f64], corners: &[Vec<f64>; 2]) -> Option<SeparatorView> {
        let back = |x: P| coordinates(scale(x, -self.exponent));
        let length = |x: f64| scale(P::splat(x), -self.exponent).coord(0);
        let (kind, vector, number, interior) = match Separator::<P>::from_array(words)?.surface()? {
            Surface::Sphere { centre, radius, ball_is_interior } => {
                let interior = if ball_is_interior { "ball" } else { "around" };
                ("sphere", back(centre), length(radius), interior)
            }
            Surface::Plane { normal, offset } => ("plane", coordinates(normal), length(offset), "below"),
        };
        let finite = number.is_finite() && vector.iter().all(|v| v.is_finite());
        finite.then(|| SeparatorView {
            node,
            level: NodeId(node).level(),
            kind,
            vector,
            number,
            interior,
            low: self.shown(&corners[0]),
            high: self.shown(&corners[1]),
        })
    }
}
