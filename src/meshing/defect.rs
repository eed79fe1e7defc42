//! Defects of inputs.
//!
//! Every defect gives the offending elements, by their positions in the input, and a location. The
//! [`DomainKind`](crate::input::DomainKind) of the input decides whether some properties are defects:
//!
//! | | complex | surface |
//! | --- | --- | --- |
//! | edge of one facet, dangling facet or segment | legal | [`OpenEdge`](Defect::OpenEdge) |
//! | edge of three or more facets, several fans at a vertex | legal | not manifold; [`accept`](crate::accept()) refuses only odd numbers |
//! | vertex on a segment or in a facet of others | legal, they are divided | [`Intersect`](Defect::Intersect) |
//! | nothing is enclosed | [`Unclosed`](Defect::Unclosed) | follows from the open edges |
//! | everything else below | defect | defect |
//!
//! Equal points are a defect of [`check`](crate::check()), and none of [`accept`](crate::accept()).

use std::fmt;

/// An element of the input, by its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Element {
    /// A point.
    Point(u32),
    /// An edge between two points: a listed segment, or an edge of a facet's polygon.
    Segment([u32; 2]),
    /// A facet. In a surface, a face.
    Facet(u32),
    /// A hole point.
    Hole(u32),
    /// A region.
    Region(u32),
}

impl Element {
    /// Formats the element with the indices of a file that counts from `first_id`.
    pub fn in_file(self, first_id: u64) -> String {
        let id = |position: u32| u64::from(position) + first_id;
        match self {
            Element::Point(i) => format!("point {}", id(i)),
            Element::Segment([a, b]) => format!("segment {}-{}", id(a), id(b)),
            Element::Facet(i) => format!("facet {}", id(i)),
            Element::Hole(i) => format!("hole point {}", id(i)),
            Element::Region(i) => format!("region {}", id(i)),
        }
    }
}

/// A location: 2 or 3 coordinates in the unit of the file, rounded.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
pub struct At(pub Vec<f64>);

impl fmt::Display for At {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("(")?;
        for (i, c) in self.0.iter().enumerate() {
            write!(f, "{}{c}", if i == 0 { "" } else { ", " })?;
        }
        f.write_str(")")
    }
}

/// The reason why the location of a hole point or region point is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Misplaced {
    /// On a segment or facet.
    OnBoundary,
    /// Outside the domain.
    Outside,
    /// A region point in a hole.
    InHole,
}

/// A defect of an input.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
#[non_exhaustive]
pub enum Defect {
    /// There are no facets and no segments.
    Empty,
    /// Coordinates are not finite, or their range is too large for exact signs. The text gives the details.
    Range(String),
    /// An element refers to a point that does not exist.
    NoSuchPoint {
        /// The element.
        element: Element,
        /// The position of the point.
        named: u64,
        /// The number of points.
        count: u64,
    },
    /// Several points have the same coordinates.
    Duplicate {
        /// The points, in ascending order.
        points: Vec<u32>,
        /// Their coordinates.
        at: At,
    },
    /// The ends of a segment coincide, or a facet has no area.
    Degenerate {
        /// The element.
        element: Element,
        /// One of its corners.
        at: At,
    },
    /// A corner of a facet does not lie in the plane of the others.
    NotPlanar {
        /// The facet.
        facet: u32,
        /// The corner.
        point: u32,
        /// Its distance from the plane of the first three corners that are not collinear.
        distance: f64,
        /// The coordinates of the corner.
        at: At,
    },
    /// A hole point of a facet does not lie in a hole.
    FacetHole {
        /// The facet.
        facet: u32,
        /// The index of the hole point within the facet.
        hole: u32,
        /// Its coordinates.
        at: At,
    },
    /// Two elements overlap.
    Doubled {
        /// The elements. If the polygons of a facet overlap, both entries are this facet.
        elements: [Element; 2],
        /// A common point.
        at: At,
    },
    /// Two elements meet outside common vertices and edges.
    Intersect {
        /// The elements.
        elements: [Element; 2],
        /// An approximate common point.
        at: At,
    },
    /// An edge of a surface has only one face.
    OpenEdge {
        /// Its ends.
        ends: [u32; 2],
        /// The face.
        facet: u32,
        /// Its midpoint.
        at: At,
    },
    /// An edge of a surface has more than two faces.
    NonManifoldEdge {
        /// Its ends.
        ends: [u32; 2],
        /// The faces.
        facets: Vec<u32>,
        /// Its midpoint.
        at: At,
    },
    /// Several fans of faces meet at a vertex of a surface.
    NonManifoldVertex {
        /// The vertex.
        point: u32,
        /// The number of fans.
        fans: u32,
        /// Its coordinates.
        at: At,
    },
    /// A surface contains an element that is allowed only in complexes.
    Dangling {
        /// The element.
        element: Element,
        /// One of its points.
        at: At,
    },
    /// The facets and segments enclose only holes.
    Unclosed,
    /// The location of a hole point or region point is invalid.
    Misplaced {
        /// The hole or region.
        element: Element,
        /// The reason.
        place: Misplaced,
        /// Its coordinates.
        at: At,
    },
    /// A shell is so thin that no line in general position passes through it.
    TooThin {
        /// A facet or segment of the shell.
        element: Element,
        /// One of its points.
        at: At,
    },
    /// No wall separates two regions.
    SharedComponent {
        /// The regions.
        regions: [u32; 2],
        /// The point of the second region.
        at: At,
    },
}

impl Defect {
    /// Formats the defect with the indices of a file that counts from `first_id`.
    pub fn in_file(&self, first_id: u64) -> InFile<'_> {
        InFile { defect: self, first_id }
    }

    /// Returns a short name for the kind of defect, for use in counts.
    pub fn kind(&self) -> &'static str {
        match self {
            Defect::Empty => "empty domain",
            Defect::Range(_) => "coordinates out of range",
            Defect::NoSuchPoint { .. } => "index out of range",
            Defect::Duplicate { .. } => "duplicate points",
            Defect::Degenerate { .. } => "degenerate element",
            Defect::NotPlanar { .. } => "facet not planar",
            Defect::FacetHole { .. } => "misplaced hole point of a facet",
            Defect::Doubled { .. } => "overlap",
            Defect::Intersect { .. } => "intersection",
            Defect::OpenEdge { .. } => "open edge",
            Defect::NonManifoldEdge { .. } => "edge not manifold",
            Defect::NonManifoldVertex { .. } => "vertex not manifold",
            Defect::Dangling { .. } => "dangling element",
            Defect::Unclosed => "nothing enclosed",
            Defect::Misplaced { .. } => "misplaced hole or region point",
            Defect::TooThin { .. } => "thin shell",
            Defect::SharedComponent { .. } => "regions not separated",
        }
    }
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.in_file(0).fmt(f)
    }
}

/// A defect that is displayed with the indices of its file.
#[derive(Clone, Copy, Debug)]
pub struct InFile<'a> {
    defect: &'a Defect,
    first_id: u64,
}

impl InFile<'_> {
    fn id(&self, position: u32) -> u64 {
        u64::from(position) + self.first_id
    }

    fn element(&self, element: Element) -> String {
        element.in_file(self.first_id)
    }

    fn list(&self, ids: &[u32]) -> String {
        ids.iter().map(|&i| self.id(i).to_string()).collect::<Vec<_>>().join(", ")
    }
}

impl fmt::Display for InFile<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.defect {
            Defect::Empty => write!(f, "no facets and no segments: a domain needs a boundary"),
            Defect::Range(text) => f.write_str(text),
            Defect::NoSuchPoint { element, named, count } => write!(
                f,
                "{} refers to point {}, but there are {count} points",
                self.element(*element),
                named + self.first_id
            ),
            Defect::Duplicate { points, at } => {
                write!(f, "points {} have the same coordinates {at}", self.list(points))
            }
            Defect::Degenerate { element, at } => {
                let missing = if matches!(element, Element::Segment(_)) { "length" } else { "area" };
                write!(f, "{} has no {missing}, at {at}", self.element(*element))
            }
            Defect::NotPlanar { facet, point, distance, at } => write!(
                f,
                "facet {} is not planar: point {} at {at} is at distance {distance:e} from its plane",
                self.id(*facet),
                self.id(*point)
            ),
            Defect::FacetHole { facet, hole, at } => write!(
                f,
                "hole point {} of facet {} at {at} does not lie inside a loop of the facet",
                self.id(*hole),
                self.id(*facet)
            ),
            Defect::Doubled { elements: [a, b], at } => {
                write!(f, "{} and {} overlap at {at}", self.element(*a), self.element(*b))
            }
            Defect::Intersect { elements: [a, b], at } => {
                write!(f, "{} and {} intersect, near {at}", self.element(*a), self.element(*b))
            }
            _ => self.surface(f),
        }
    }
}

impl InFile<'_> {
    /// Formats the defects of surfaces and of their components.
    fn surface(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.defect {
            Defect::OpenEdge { ends, facet, at } => write!(
                f,
                "the surface is open: edge {}-{} at {at} belongs only to facet {}",
                self.id(ends[0]),
                self.id(ends[1]),
                self.id(*facet)
            ),
            Defect::NonManifoldEdge { ends, facets, at } => write!(
                f,
                "edge {}-{} at {at} has {} facets: {}",
                self.id(ends[0]),
                self.id(ends[1]),
                facets.len(),
                self.list(facets)
            ),
            Defect::NonManifoldVertex { point, fans, at } => {
                write!(f, "point {} at {at} joins {fans} fans of facets", self.id(*point))
            }
            Defect::Dangling { element, at } => {
                write!(f, "{} at {at} is a dangling element of a closed surface", self.element(*element))
            }
            Defect::Unclosed => write!(f, "the facets and segments enclose only holes"),
            Defect::Misplaced { element, place, at } => {
                let place = match place {
                    Misplaced::OnBoundary => "lies on a segment or facet",
                    Misplaced::Outside => "lies outside the domain",
                    Misplaced::InHole => "lies in a hole",
                };
                write!(f, "{} at {at} {place}", self.element(*element))
            }
            Defect::TooThin { element, at } => {
                write!(
                    f,
                    "{} at {at} belongs to a shell that is too thin to have an interior",
                    self.element(*element)
                )
            }
            Defect::SharedComponent { regions: [a, b], at } => write!(
                f,
                "regions {} and {} lie in one component, {} at {at}: no facet separates them",
                self.id(*a),
                self.id(*b),
                self.id(*b)
            ),
            _ => Ok(()),
        }
    }
}
