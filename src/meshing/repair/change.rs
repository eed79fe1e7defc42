//! The changes of an input before its exact check.

use std::fmt;

use crate::defect::{At, Element};

/// The reason why an element was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dropped {
    /// Its corners were joined by a weld.
    Collapsed,
    /// It has no length or no area.
    Degenerate,
    /// Another facet has the same corners.
    Double,
}

/// A change of an input, or a property that strict rules refuse. Ids are positions in the input.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
#[non_exhaustive]
pub enum Change {
    /// Points with equal coordinates count as one.
    Welded {
        /// The number of positions with several points.
        places: u64,
        /// The number of points that another one stands for.
        points: u64,
        /// The first position.
        at: At,
    },
    /// Points were moved to others at most the weld distance away.
    Moved {
        /// The number of points.
        points: u64,
        /// The largest distance.
        most: f64,
        /// The original position of the point that moved by it.
        at: At,
    },
    /// Facets are planar only within the digits of the coordinates. They count as triangles.
    NotFlat {
        /// The number of facets.
        facets: u64,
        /// The facet whose corner is furthest from its plane.
        facet: u32,
        /// The distance of that corner.
        most: f64,
        /// Its coordinates.
        at: At,
        /// The limit.
        limit: f64,
    },
    /// Edges of a surface with four or more facets, or vertices with several fans. Parity decides which parts are inside.
    NotManifold {
        /// The number of edges.
        edges: u64,
        /// The number of vertices.
        vertices: u64,
        /// The first place.
        at: At,
    },
    /// The solids of the input are closed, and each is a region.
    Regions {
        /// The names of the solids. The attribute of a region counts them from 1.
        names: Vec<String>,
        /// The number of facets that two solids share.
        shared: u64,
    },
    /// The solids of the input are parts of one surface, and their numbers are markers of the facets.
    Parts {
        /// The names of the solids. Markers count them from 1.
        names: Vec<String>,
    },
    /// Repair: a point on an edge became a corner of the facet.
    Divided {
        /// The facet.
        facet: u32,
        /// The edge.
        ends: [u32; 2],
        /// The point.
        point: u32,
        /// Its distance from the edge.
        distance: f64,
        /// Its coordinates.
        at: At,
    },
    /// An element was dropped.
    Dropped {
        /// The element.
        element: Element,
        /// The reason.
        why: Dropped,
        /// One of its corners.
        at: At,
    },
    /// Repair: a facet that is not planar was divided into triangles.
    Bent {
        /// The facet.
        facet: u32,
        /// The largest distance of a corner from its plane.
        distance: f64,
        /// The coordinates of that corner.
        at: At,
    },
    /// Repair: a hole was closed.
    Filled {
        /// The vertices around the hole.
        around: Vec<u32>,
        /// The number of new triangles.
        triangles: u32,
        /// The area of the new triangles.
        area: f64,
        /// The first of the vertices.
        at: At,
    },
}

impl Change {
    /// Returns `true` for repairs, which are made only on request. Others are notes.
    pub fn is_repair(&self) -> bool {
        match self {
            Change::Divided { .. } | Change::Bent { .. } | Change::Filled { .. } => true,
            Change::Dropped { why, .. } => *why != Dropped::Collapsed,
            Change::Welded { .. }
            | Change::Moved { .. }
            | Change::NotFlat { .. }
            | Change::NotManifold { .. }
            | Change::Regions { .. }
            | Change::Parts { .. } => false,
        }
    }

    /// Formats the change with the ids of a file that counts from `first_id`.
    pub fn in_file(&self, first_id: u64) -> ChangeInFile<'_> {
        ChangeInFile { change: self, first_id }
    }
}

/// A change that is displayed with the ids of its file.
#[derive(Clone, Copy, Debug)]
pub struct ChangeInFile<'a> {
    change: &'a Change,
    first_id: u64,
}

fn counted(number: u64, noun: &str) -> String {
    let plural = match noun {
        "vertex" => "vertices".to_owned(),
        other => format!("{other}s"),
    };
    if number == 1 { format!("1 {noun}") } else { format!("{number} {plural}") }
}

fn numbered(names: &[String]) -> String {
    let named = names.iter().enumerate().map(|(i, name)| format!("{} {name}", i + 1));
    named.collect::<Vec<_>>().join(", ")
}

impl fmt::Display for ChangeInFile<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let id = |position: u32| u64::from(position) + self.first_id;
        match self.change {
            Change::Welded { places, points, at } => {
                let (points, places) = (counted(*points, "point"), counted(*places, "place"));
                write!(f, "{points} welded to equal points at {places}, the first at {at}")
            }
            Change::Moved { points, most, at } => write!(
                f,
                "{} moved to neighbours within the weld distance, by at most {most:e} at {at}",
                counted(*points, "point")
            ),
            Change::NotFlat { facets, facet, most, at, limit } => write!(
                f,
                "{} planar only within the digits of the coordinates, and divided into triangles: a corner of facet {} at \
                 {at} is {most:e} off its plane (limit {limit:e})",
                counted(*facets, "facet"),
                id(*facet)
            ),
            Change::NotManifold { edges, vertices, at } => write!(
                f,
                "the surface is not manifold at {} and {}, the first at {at}: parity decides what is inside",
                counted(*edges, "edge"),
                counted(*vertices, "vertex")
            ),
            Change::Regions { names, shared } => write!(
                f,
                "each solid is a region: {}; {} between two of them",
                numbered(names),
                counted(*shared, "facet")
            ),
            Change::Parts { names } => {
                write!(f, "the solids are parts of one surface, with markers: {}", numbered(names))
            }
            _ => self.repair(f),
        }
    }
}

impl ChangeInFile<'_> {
    fn repair(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let id = |position: u32| u64::from(position) + self.first_id;
        match self.change {
            Change::Divided { facet, ends, point, distance, at } => write!(
                f,
                "edge {}-{} of facet {} was divided at point {} at {at}, {distance:e} away",
                id(ends[0]),
                id(ends[1]),
                id(*facet),
                id(*point)
            ),
            Change::Dropped { element, why, at } => {
                let why = match why {
                    Dropped::Collapsed => "its corners were welded",
                    Dropped::Degenerate if matches!(element, Element::Segment(_)) => "it has no length",
                    Dropped::Degenerate => "it has no area",
                    Dropped::Double => "another facet has the same corners",
                };
                write!(f, "{} at {at} was dropped: {why}", element.in_file(self.first_id))
            }
            Change::Bent { facet, distance, at } => write!(
                f,
                "facet {} was divided into triangles: its corner at {at} is {distance:e} off its plane",
                id(*facet)
            ),
            Change::Filled { around, triangles, area, at } => {
                let around = around.iter().map(|&v| id(v).to_string()).collect::<Vec<_>>().join("-");
                let triangles = counted(u64::from(*triangles), "triangle");
                write!(f, "the hole {around} at {at} was closed by {triangles} of area {area:e}")
            }
            _ => Ok(()),
        }
    }
}
