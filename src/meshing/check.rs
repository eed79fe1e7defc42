//! The check of an input, which returns a domain or all defects of the input.
//!
//! **Statement.** The checks run in this order:
//! 1. Each element by itself ([`crate::resolve`]).
//! 2. Contacts between elements ([`crate::contact`]).
//! 3. Whether a surface is a closed manifold ([`crate::manifold`]).
//! 4. If there is no defect so far, the components of the complement of the walls ([`crate::sides`]), and the
//!    positions of holes and regions.
//!
//! The documentation of [`crate::defect`] lists the defects of each kind of input.

use crate::contact::contacts;
use crate::defect::{At, Defect, Element, Misplaced};
use crate::digits::Digits;
use crate::domain::{Component, Domain};
use crate::facet::Triangulate;
use crate::input::{DomainKind, Input};
use crate::joining::flats_of;
use crate::manifold::manifold;
use crate::repair::{Change, Prepared, Repair, Solids, Tolerance, prepare};
use crate::resolve::{Simplices, resolve};
use crate::sides::{Location, Sides};
use crate::space::Space;

/// A domain, and the changes of the input.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Accepted<P: Space> {
    /// The domain.
    pub domain: Domain<P>,
    /// The changes, and the deviations that strict rules would have refused.
    pub changes: Vec<Change>,
}

/// Checks an input exactly, and prepares its domain for meshing.
///
/// # Errors
/// Returns all defects, in an order that depends only on the input. The list is not empty.
pub fn check<P: Triangulate>(input: &Input<P>) -> Result<Domain<P>, Vec<Defect>> {
    let (simplices, defects) = complex(input)?;
    if !defects.is_empty() {
        return Err(defects);
    }
    domain(input, simplices, None)
}

/// Prepares an input ([`crate::repair`]), checks it, and prepares its domain for meshing. Equal points, and edges and
/// vertices that are not manifold, count as defects only if the tolerance is strict.
///
/// # Errors
/// Returns all defects that are left, in an order that depends only on the input. The list is not empty.
pub fn accept<P: Repair>(input: &Input<P>, tolerance: &Tolerance) -> Result<Accepted<P>, Vec<Defect>> {
    if tolerance.strict {
        return check(input).map(|domain| Accepted { domain, changes: Vec::new() });
    }
    let mut prepared = prepare(input, tolerance);
    let checked = complex(&prepared.input).and_then(|(simplices, defects)| {
        let (accepted, defects): (Vec<_>, Vec<_>) =
            defects.into_iter().partition(|d| is_accepted(d, &prepared));
        prepared.changes.extend(welded(&accepted));
        prepared.changes.extend(not_manifold(&accepted).filter(|_| prepared.solids.is_none()));
        if !defects.is_empty() {
            return Err(defects);
        }
        let mut domain = domain(&prepared.input, simplices, prepared.solids.as_ref())?;
        domain.manifold &= prepared.solids.is_none() && not_manifold(&accepted).is_none();
        Ok(domain)
    });
    let mut domain = checked.map_err(|defects| -> Vec<Defect> {
        defects.into_iter().map(|defect| prepared.in_file(defect)).collect()
    })?;
    let Prepared { origin, changes, .. } = prepared;
    if P::DIM == 3 {
        domain.simplices.owner.iter_mut().for_each(|f| *f = origin[*f as usize]);
        for facet in &mut domain.facets {
            facet.of.iter_mut().for_each(|f| *f = origin[*f as usize]);
            facet.of.dedup();
        }
    }
    Ok(Accepted { domain, changes })
}

/// Returns `true` for a defect that only strict rules refuse.
fn is_accepted<P>(defect: &Defect, prepared: &Prepared<P>) -> bool {
    match defect {
        Defect::Duplicate { .. } | Defect::NonManifoldVertex { .. } => true,
        Defect::NonManifoldEdge { facets, .. } => facets.len().is_multiple_of(2) || prepared.solids.is_some(),
        _ => false,
    }
}

/// Sums up the points with equal coordinates.
fn welded(accepted: &[Defect]) -> Option<Change> {
    let groups = accepted.iter().filter_map(|defect| match defect {
        Defect::Duplicate { points, at } => Some((points.len() as u64 - 1, at)),
        _ => None,
    });
    let all: Vec<(u64, &At)> = groups.collect();
    let at = all.first()?.1.clone();
    Some(Change::Welded { places: all.len() as u64, points: all.iter().map(|g| g.0).sum(), at })
}

/// Sums up the edges and vertices that are not manifold.
fn not_manifold(accepted: &[Defect]) -> Option<Change> {
    let places = accepted.iter().filter_map(|defect| match defect {
        Defect::NonManifoldEdge { at, .. } => Some(([1, 0], at)),
        Defect::NonManifoldVertex { at, .. } => Some(([0, 1], at)),
        _ => None,
    });
    let all: Vec<([u64; 2], &At)> = places.collect();
    let at = all.first()?.1.clone();
    let [edges, vertices] = [0, 1].map(|i| all.iter().map(|p| p.0[i]).sum());
    Some(Change::NotManifold { edges, vertices, at })
}

/// Returns the simplices of an input, and the defects of its elements and contacts.
fn complex<P: Triangulate>(input: &Input<P>) -> Result<(Simplices<P>, Vec<Defect>), Vec<Defect>> {
    let (simplices, mut defects) = resolve(input);
    let Some(simplices) = simplices else { return Err(defects) };
    defects.extend(contacts(&simplices));
    if input.kind == DomainKind::Surface {
        defects.extend(manifold(input, &simplices));
    }
    Ok((simplices, defects))
}

/// Finds the components, and builds the domain of a complex without defects.
fn domain<P: Triangulate>(
    input: &Input<P>,
    simplices: Simplices<P>,
    solids: Option<&Solids>,
) -> Result<Domain<P>, Vec<Defect>> {
    let sides = Sides::new(&simplices).map_err(|undecided| {
        let at = simplices.place(simplices.walls[undecided.0 as usize].as_ref()[0]);
        vec![Defect::TooThin { element: simplices.element(undecided.0), at }]
    })?;
    let mut components = components(input, &simplices, &sides)?;
    let regions = solids.map(|solids| solids.classify(&simplices, &sides, &mut components));
    let mut domain = Domain::new(input, simplices, sides, components);
    let step = domain.simplices.frame.scaled_length(Digits::of(&input.points).step());
    domain.flats = flats_of(&domain, step);
    if let Some(regions) = regions {
        domain.regions = regions;
    }
    Ok(domain)
}

/// Classifies every component as outside, hole, or part of the domain, and finds its region.
fn components<P: Triangulate>(
    input: &Input<P>,
    simplices: &Simplices<P>,
    sides: &Sides<P>,
) -> Result<Vec<Component>, Vec<Defect>> {
    let measures = sides.measures(&simplices.points);
    let mut components: Vec<Component> = (0..sides.count())
        .map(|c| Component {
            inside: c > 0 && (input.kind == DomainKind::Complex || sides.is_odd(c)),
            region: None,
            measure: measures[c as usize],
        })
        .collect();
    let mut defects = Vec::new();
    let mut component_of = |at: P, element: Element| {
        let at = simplices.frame.inward(at);
        let place = match sides.locate(&simplices.points, at) {
            Some(Location::Component(0)) => Misplaced::Outside,
            Some(Location::Component(c)) => return Some(c as usize),
            Some(Location::Wall(_)) | None => Misplaced::OnBoundary,
        };
        defects.push(Defect::Misplaced { element, place, at: simplices.at(at) });
        None
    };
    let holes: Vec<_> =
        input.holes.iter().enumerate().map(|(i, &h)| component_of(h, Element::Hole(i as u32))).collect();
    let regions: Vec<_> = input
        .regions
        .iter()
        .enumerate()
        .map(|(i, r)| component_of(r.at, Element::Region(i as u32)))
        .collect();
    for hole in holes.into_iter().flatten() {
        components[hole].inside = false;
    }
    for (i, component) in regions.into_iter().enumerate() {
        let Some(c) = component else { continue };
        let at = simplices.at(simplices.frame.inward(input.regions[i].at));
        match components[c].region {
            _ if !components[c].inside => {
                let element = Element::Region(i as u32);
                defects.push(Defect::Misplaced { element, place: Misplaced::InHole, at });
            }
            Some(first) => defects.push(Defect::SharedComponent { regions: [first, i as u32], at }),
            None => components[c].region = Some(i as u32),
        }
    }
    if !components.iter().any(|c| c.inside) {
        defects.push(Defect::Unclosed);
    }
    if defects.is_empty() { Ok(components) } else { Err(defects) }
}
