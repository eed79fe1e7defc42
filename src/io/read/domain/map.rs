//! The shapes of a map file as a domain.

use septet_meshing::plane::Shapes;

use super::any::{AnyInput, DomainFile};

/// The shapes of a file, and what was left out of them.
#[derive(Clone, Debug, Default)]
pub struct MapFile {
    /// The shapes.
    pub shapes: Shapes,
    /// Whether some feature has properties.
    pub has_properties: bool,
    /// The coordinate system that the file names.
    pub system: Option<String>,
    /// The number of features without a geometry.
    pub empty: u64,
    /// The number of rings that do not end where they begin.
    pub open_rings: u64,
}

impl MapFile {
    /// Appends a ring, which is closed if its last position is not its first.
    pub fn close(&mut self, ring: &[u32]) {
        let at = |v: &u32| self.shapes.points[*v as usize];
        if ring.first().map(at) != ring.last().map(at) {
            self.open_rings += 1;
        }
    }

    /// Returns what a user should know about the file.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.has_properties {
            notes.push("the properties of the features are ignored".to_owned());
        }
        if let Some(system) = &self.system {
            notes.push(format!("the coordinate system {system} is ignored: coordinates are not converted"));
        }
        if self.empty > 0 {
            notes.push(format!("features without a geometry: {}, which have no region", self.empty));
        }
        if self.open_rings > 0 {
            notes.push(format!(
                "rings that did not end where they began: {}, which were closed",
                self.open_rings
            ));
        }
        notes
    }

    /// Returns the domain.
    pub fn into_domain(self) -> DomainFile {
        let mut notes = self.notes();
        if self.shapes.heights.iter().any(|z| !z.is_nan()) {
            notes.push("heights are ignored, because a domain of polygons lies in the plane".to_owned());
        }
        if self.shapes.features > 1 && !self.shapes.polygons.is_empty() {
            notes.push(format!(
                "regions and markers are the numbers of the features, 1 to {}",
                self.shapes.features
            ));
        }
        let (input, overlaps) = self.shapes.domain();
        if overlaps {
            notes.push("features overlap: the first one gives the region".to_owned());
        }
        DomainFile { input: AnyInput::Plane(input), notes, first_id: 1 }
    }
}
