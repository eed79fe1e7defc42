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
use crate::defect::{Defect, Element, Misplaced};
use crate::digits::step_of;
use crate::domain::{Component, Domain};
use crate::facet::Triangulate;
use crate::input::{DomainKind, Input};
use crate::joining::flats_of;
use crate::manifold::manifold;
use crate::resolve::{Simplices, resolve};
use crate::sides::{Location, Sides};

/// Checks an input and prepares its domain for meshing.
///
/// # Errors
/// Returns all defects, in an order that depends only on the input. The list is not empty.
pub fn check<P: Triangulate>(input: &Input<P>) -> Result<Domain<P>, Vec<Defect>> {
    let (simplices, mut defects) = resolve(input);
    let Some(simplices) = simplices else { return Err(defects) };
    defects.extend(contacts(&simplices));
    if input.kind == DomainKind::Surface {
        defects.extend(manifold(input, &simplices));
    }
    if !defects.is_empty() {
        return Err(defects);
    }
    let sides = Sides::new(&simplices).map_err(|undecided| {
        let at = simplices.place(simplices.walls[undecided.0 as usize].as_ref()[0]);
        vec![Defect::TooThin { element: simplices.element(undecided.0), at }]
    })?;
    let components = components(input, &simplices, &sides)?;
    let mut domain = Domain::new(input, simplices, sides, components);
    let step = domain.simplices.frame.scaled_length(step_of(&input.points));
    domain.flats = flats_of(&domain, step);
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
