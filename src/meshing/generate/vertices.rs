//! The vertices of a mesh during generation.

use septet_geometry::point::Point;

use crate::domain::Domain;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::sides::Sets;
use crate::space::Space;

/// Vertices as a structure of arrays, corners first.
#[derive(Clone, Debug, Default)]
pub struct Vertices<P> {
    /// Positions, in the scaled coordinates of the domain.
    pub points: Vec<P>,
    /// The size function at each vertex.
    pub sizes: Vec<f64>,
    /// The carrier of each vertex.
    pub carriers: Vec<Carrier>,
}

impl<P: Point> Vertices<P> {
    /// Appends a vertex.
    pub fn push(&mut self, site: Site<P>, carrier: Carrier) {
        self.points.push(site.at);
        self.sizes.push(site.size);
        self.carriers.push(carrier);
    }

    /// Keeps the marked vertices and renumbers them consecutively.
    pub fn keep(&mut self, kept: &[bool]) {
        let kept = |list: usize| (0..list).filter(|&v| kept[v]).collect::<Vec<usize>>();
        let kept = kept(self.points.len());
        self.points = kept.iter().map(|&v| self.points[v]).collect();
        self.sizes = kept.iter().map(|&v| self.sizes[v]).collect();
        self.carriers = kept.iter().map(|&v| self.carriers[v]).collect();
    }

    /// Returns the number of vertices.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns `true` if there are no vertices.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Returns all vertices as sites.
    pub fn sites(&self) -> Vec<Site<P>> {
        self.points.iter().zip(&self.sizes).map(|(&at, &size)| Site { at, size }).collect()
    }
}

/// The features of codimension one that contain each carrier: facets in space, segments in the plane.
#[derive(Clone, Debug)]
pub struct Holders {
    corners: Vec<Vec<u32>>,
    segments: Vec<Vec<u32>>,
    /// The list for a point inside a facet: only the facet.
    single: Vec<u32>,
}

impl Holders {
    /// Collects the facets (in the plane: segments) of a domain.
    pub fn new<P: Space>(domain: &Domain<P>) -> Self {
        let corner = |v: u32| domain.corners.binary_search(&v).ok();
        let mut corners = vec![Vec::new(); domain.corners.len()];
        let mut segments = vec![Vec::new(); domain.segments.len()];
        if P::DIM == 2 {
            for (s, segment) in (0u32..).zip(&domain.segments) {
                segments[s as usize].push(s);
                segment.ends().into_iter().filter_map(corner).for_each(|c| corners[c].push(s));
            }
        } else {
            for (f, facet) in (0u32..).zip(&domain.facets) {
                facet.boundary.iter().chain(&facet.internal).for_each(|&s| segments[s as usize].push(f));
                facet.corners.iter().filter_map(|&v| corner(v)).for_each(|c| corners[c].push(f));
            }
        }
        let single = (0..domain.facets.len() as u32).collect();
        Holders { corners, segments, single }
    }

    /// Replaces each facet by the group given for it.
    #[must_use]
    pub fn grouped(&self, group: &[u32]) -> Self {
        let one = |list: &Vec<u32>| {
            let mut list: Vec<u32> = list.iter().map(|&f| group[f as usize]).collect();
            list.sort_unstable();
            list.dedup();
            list
        };
        Holders {
            corners: self.corners.iter().map(one).collect(),
            segments: self.segments.iter().map(one).collect(),
            single: group.to_vec(),
        }
    }

    /// Collects the segments that contain each carrier.
    pub fn of_segments<P: Space>(domain: &Domain<P>) -> Self {
        let mut corners = vec![Vec::new(); domain.corners.len()];
        for (s, segment) in (0u32..).zip(&domain.segments) {
            let ends = segment.ends().into_iter().filter_map(|v| domain.corners.binary_search(&v).ok());
            ends.for_each(|c| corners[c].push(s));
        }
        let segments = (0..domain.segments.len() as u32).map(|s| vec![s]).collect();
        let single = (0..domain.facets.len() as u32).collect();
        Holders { corners, segments, single }
    }

    /// Returns the features that contain a carrier, ascending.
    pub fn of(&self, carrier: &Carrier) -> &[u32] {
        match carrier {
            Carrier::Corner(c) => &self.corners[*c as usize],
            Carrier::Segment(s) => &self.segments[*s as usize],
            Carrier::Facet(f) => std::slice::from_ref(&self.single[*f as usize]),
            Carrier::Volume => &[],
        }
    }

    /// Returns the features that contain all given vertices, ascending.
    pub fn common(&self, carriers: &[Carrier], vertices: &[u32]) -> Vec<u32> {
        let Some((&first, others)) = vertices.split_first() else { return Vec::new() };
        // Most lists contain a vertex in the volume, which lies on no feature.
        if others.iter().any(|&v| self.of(&carriers[v as usize]).is_empty()) {
            return Vec::new();
        }
        let mut common = self.of(&carriers[first as usize]).to_vec();
        for &v in others {
            if common.is_empty() {
                break;
            }
            let list = self.of(&carriers[v as usize]);
            common.retain(|f| list.binary_search(f).is_ok());
        }
        common
    }
}

/// Groups facets (in the plane: segments) that meet and are coplanar up to rounding. Returns, for each of them, the
/// first member of its group. A cell with all vertices on one group is flat up to rounding.
pub fn flat_groups<P: Space>(domain: &Domain<P>) -> Vec<u32> {
    let at = |v: u32| domain.points()[v as usize];
    let mut sets = Sets::new(if P::DIM == 2 { domain.segments.len() } else { domain.facets.len() });
    let mut join = |all: &[u32], normal: &dyn Fn(u32) -> P| {
        for (i, &f) in all.iter().enumerate() {
            for &g in &all[..i] {
                let (m, n) = (normal(f), normal(g));
                let product = m.norm2() * n.norm2();
                // The squared sine of the angle between the normals.
                if product - m.dot(n) * m.dot(n) <= FLAT * FLAT * product {
                    sets.join(f, g);
                }
            }
        }
    };
    if P::DIM == 2 {
        let along = |s: u32| {
            let [a, b] = domain.segments[s as usize].ends();
            at(b) - at(a)
        };
        domain.segments_at().values().for_each(|all| join(all, &along));
    } else {
        let normal = |f: u32| normal_of(domain, f);
        domain.segments.iter().for_each(|s| join(&s.facets, &normal));
    }
    let n = if P::DIM == 2 { domain.segments.len() } else { domain.facets.len() };
    (0..n as u32).map(|f| sets.find(f)).collect()
}

/// The sine of the largest angle between facets that count as coplanar.
const FLAT: f64 = 1e-7;

/// Returns the normal of the largest triangle of a facet.
pub(crate) fn normal_of<P: Space>(domain: &Domain<P>, f: u32) -> P {
    let normal = |w: &u32| {
        let v = domain.walls()[*w as usize];
        let [a, b, c] = [0, 1, 2].map(|i| domain.points()[v.as_ref()[i] as usize]);
        P::hull_normal(&[b - a, c - a])
    };
    let normals = domain.facets[f as usize].walls.iter().map(normal);
    normals.max_by(|m, n| m.norm2().total_cmp(&n.norm2())).unwrap_or_default()
}
