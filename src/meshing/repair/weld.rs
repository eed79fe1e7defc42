//! Welding: points near each other become one.
//!
//! **Statement.** In lexicographic order, each point joins the nearest earlier point that joined none, if one is within
//! the distance. So no point moves further than the distance, joined points have equal coordinates, those that joined
//! none keep theirs, and the numbering has no effect. Ids stay: the exact check identifies points with equal
//! coordinates. Two remaining points may still be within the distance of a third.
//!
//! Elements whose corners are joined to fewer than they need are dropped.
//!
//! **Work and depth.** `O(m log m)`, plus the pairs within the distance, sequential.

use std::collections::BTreeMap;

use septet_geometry::point::lex_cmp;

use super::change::{Change, Dropped};
use super::mending::Mending;
use crate::bvh::{Bounds, Bvh};
use crate::defect::Element;
use crate::space::Space;

/// Welds points within a distance.
pub(super) fn weld<P: Space>(mending: &mut Mending<P>, distance: f64) {
    let old = mending.input.points.clone();
    let before = mending.same();
    let mut order: Vec<u32> = (0..old.len() as u32).collect();
    order.sort_by(|&a, &b| lex_cmp(&old[a as usize], &old[b as usize]).then(a.cmp(&b)));
    let tree = Bvh::new(old.iter().map(|&p| Bounds::of([p])).collect());
    let mut rank: BTreeMap<u32, usize> = BTreeMap::new();
    let (mut points, mut most) = (0, (0.0, 0));
    for (k, &v) in order.iter().enumerate() {
        let p = old[v as usize];
        let reach = P::splat(distance);
        let near = tree.meeting(&Bounds { low: p - reach, high: p + reach }).into_iter();
        let near = near.filter_map(|w| Some(((old[w as usize] - p).norm2().sqrt(), *rank.get(&w)?, w)));
        let nearest =
            near.filter(|(d, ..)| *d <= distance).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        match nearest {
            Some((d, _, w)) => {
                mending.input.points[v as usize] = old[w as usize];
                if d > 0.0 {
                    points += 1;
                    most = if d > most.0 { (d, v) } else { most };
                }
            }
            None => {
                rank.insert(v, k);
            }
        }
    }
    if points > 0 {
        let at = Mending::place(old[most.1 as usize]);
        mending.changes.push(Change::Moved { points, most: most.0, at });
    }
    drop_collapsed(mending, &before);
}

/// Drops the facets and segments whose corners were joined.
fn drop_collapsed<P: Space>(mending: &mut Mending<P>, before: &[u32]) {
    let same = mending.same();
    let id = |same: &[u32], v: u32| same.get(v as usize).copied().unwrap_or(v);
    let distinct = |same: &[u32], list: &[u32]| {
        let mut ids: Vec<u32> = list.iter().map(|&v| id(same, v)).collect();
        ids.sort_unstable();
        ids.dedup();
        ids.len()
    };
    let collapsed =
        |list: &[u32], least: usize| distinct(&same, list) < least && distinct(before, list) >= least;
    let changes = &mut mending.changes;
    let points = &mending.input.points;
    let dropped = |element, v: u32| {
        let at = points.get(v as usize).map_or_else(|| Mending::place(P::splat(0.0)), |&p| Mending::place(p));
        Change::Dropped { element, why: Dropped::Collapsed, at }
    };
    mending.input.segments.retain(|s| {
        let keep = !collapsed(&s.ends, 2);
        if !keep {
            changes.push(dropped(Element::Segment(s.ends), s.ends[0]));
        }
        keep
    });
    let mut keep = Vec::with_capacity(mending.input.facets.len());
    for (facet, &origin) in mending.input.facets.iter_mut().zip(&mending.origin) {
        let first = facet.polygons.iter().flatten().next().copied();
        let was_area = facet.polygons.iter().any(|l| distinct(before, l) >= 3);
        facet.polygons.retain(|l| !(collapsed(l, 3) || collapsed(l, 2)));
        let is_kept = facet.polygons.iter().any(|l| distinct(&same, l) >= if was_area { 3 } else { 1 });
        keep.push(is_kept || !was_area);
        if was_area && !is_kept {
            changes.push(dropped(Element::Facet(origin), first.unwrap_or(0)));
        }
    }
    mending.retain(&keep);
}
