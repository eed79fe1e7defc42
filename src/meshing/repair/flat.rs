//! Facets that are planar only within the digits of the coordinates.
//!
//! **Statement.** Four points with rounded coordinates lie in no common plane. Such a facet becomes a set of triangles,
//! which are exactly planar, between the same corners: those of a triangulation of its polygons in the projection along
//! an axis ([`Planar`]). The triangles cover the facet, meet in common edges, and have its polygons as boundary, because
//! their projections do. So neighbours still share their edges, and all later decisions are exact.
//!
//! The distance of a facet from planar is the largest distance of a corner from a plane through the mean of the
//! corners. The normal of the plane is the vector of areas of the longest polygon (Newell). Rounded distances decide
//! which facets are accepted, and a note has the largest one.
//!
//! **Work and depth.** As [`crate::planar`], for the facets that are not exactly planar.

use std::collections::BTreeMap;

use glam::DVec3;
use septet_geometry::predicates::{Sign, orientation};
use septet_geometry::range::scale;

use super::change::Change;
use super::mending::Mending;
use crate::bvh::Bounds;
use crate::input::{DomainKind, InputFacet};
use crate::planar::Planar;
use crate::space::{project, projection_axis};

/// The distance of the worst corner of a facet from its plane.
struct Off {
    distance: f64,
    corner: u32,
    normal: DVec3,
}

/// Divides facets that are planar within `limit`, a distance in the unit of the file. If `bends` is set, divides all
/// polygons of surfaces that are not planar.
pub(super) fn flatten(
    mending: &mut Mending<DVec3>,
    (scaled, exponent): (&[DVec3], i32),
    limit: f64,
    bends: bool,
) {
    let bends = bends && mending.input.kind == DomainKind::Surface;
    let mut keep = vec![true; mending.input.facets.len()];
    let (mut number, mut worst): (u64, Option<(f64, u32, u32)>) = (0, None);
    let mut parts = Vec::new();
    for (f, facet) in mending.input.facets.iter().enumerate() {
        if is_planar(facet, scaled) {
            continue;
        }
        let Some(off) = off_plane(facet, &mending.input.points) else { continue };
        let is_flat = off.distance <= limit;
        if !is_flat && !bends {
            continue;
        }
        let Some(triangles) = triangles(facet, off.normal, scaled, exponent) else { continue };
        let (origin, solids) = (mending.origin[f], mending.solids_of(f));
        keep[f] = false;
        if is_flat {
            number += 1;
            if worst.is_none_or(|w| off.distance > w.0) {
                worst = Some((off.distance, origin, off.corner));
            }
        } else {
            let at = Mending::place(mending.input.points[off.corner as usize]);
            mending.changes.push(Change::Bent { facet: origin, distance: off.distance, at });
        }
        for t in triangles {
            let part = InputFacet { polygons: vec![t.to_vec()], holes: Vec::new(), marker: facet.marker };
            parts.push((part, origin, solids.clone()));
        }
    }
    if let Some((most, facet, corner)) = worst {
        let at = Mending::place(mending.input.points[corner as usize]);
        mending.changes.push(Change::NotFlat { facets: number, facet, most, at, limit });
    }
    mending.retain(&keep);
    for (part, origin, solids) in parts {
        mending.push(part, origin, solids);
    }
}

/// Returns `true` if the facet is exactly planar, or has a defect that the check finds.
fn is_planar(facet: &InputFacet<DVec3>, scaled: &[DVec3]) -> bool {
    let corners = facet.polygons.iter().flatten();
    let corners: Option<Vec<DVec3>> = corners.map(|&v| scaled.get(v as usize).copied()).collect();
    let Some(corners) = corners.filter(|c| c.len() > 3) else { return true };
    let a = corners[0];
    let Some(&b) = corners.iter().find(|&&b| b != a) else { return true };
    let spans = |c: &&DVec3| projection_axis(a, b, **c).is_some();
    let Some(&c) = corners.iter().find(spans) else { return true };
    corners.iter().all(|&p| orientation(&[a, b, c, p]) == Sign::Zero)
}

fn off_plane(facet: &InputFacet<DVec3>, points: &[DVec3]) -> Option<Off> {
    let ids: Vec<u32> = facet.polygons.concat();
    let origin = points[ids[0] as usize];
    let at = |v: u32| points[v as usize] - origin;
    let vector =
        |l: &Vec<u32>| -> DVec3 { (0..l.len()).map(|k| at(l[k]).cross(at(l[(k + 1) % l.len()]))).sum() };
    let areas = facet.polygons.iter().map(vector);
    let normal = areas.fold(DVec3::ZERO, |m, n| if n.length_squared() > m.length_squared() { n } else { m });
    let normal = normal.try_normalize()?;
    let middle = ids.iter().map(|&v| at(v)).sum::<DVec3>() / ids.len() as f64;
    let far = ids.iter().map(|&v| ((at(v) - middle).dot(normal).abs(), v));
    let (distance, corner) = far.fold((0.0, ids[0]), |m, x| if x.0 > m.0 { x } else { m });
    Some(Off { distance, corner, normal })
}

/// Returns the triangles of a facet, or `None` if its projection is not simple.
fn triangles(
    facet: &InputFacet<DVec3>,
    normal: DVec3,
    scaled: &[DVec3],
    exponent: i32,
) -> Option<Vec<[u32; 3]>> {
    let size = normal.abs();
    let axis = (1..3).fold(0, |m, i| if size[i] > size[m] { i } else { m });
    let flat = |v: u32| project(scaled[v as usize], axis);
    let corners = facet.polygons.concat();
    let mut planar = Planar::new(&Bounds::of(corners.iter().map(|&v| flat(v))));
    let mut vertices: BTreeMap<u32, u32> = BTreeMap::new();
    let mut names: BTreeMap<u32, u32> = BTreeMap::new();
    for &v in &corners {
        let inner = planar.insert(flat(v))?;
        let first = *names.entry(inner).or_insert(v);
        if scaled[first as usize] != scaled[v as usize] {
            return None;
        }
        vertices.insert(v, inner);
    }
    let (areas, lines): (Vec<_>, Vec<_>) = facet.polygons.iter().partition(|l| l.len() > 2);
    let constrain = |polygons: Vec<&Vec<u32>>, planar: &mut Planar| {
        for l in polygons {
            for k in 0..l.len() {
                let [a, b] = [l[k], l[(k + 1) % l.len()]].map(|v| vertices[&v]);
                if a != b {
                    planar.constrain(a, b).ok()?;
                }
            }
        }
        Some(())
    };
    constrain(areas, &mut planar)?;
    planar.close();
    constrain(lines, &mut planar)?;
    let holes: Vec<_> = facet.holes.iter().map(|&h| project(scale(h, exponent), axis)).collect();
    let (triangles, misplaced) = planar.inside(&holes);
    if !misplaced.is_empty() || triangles.is_empty() {
        return None;
    }
    triangles.into_iter().map(|[a, b, c]| Some([*names.get(&a)?, *names.get(&b)?, *names.get(&c)?])).collect()
}
