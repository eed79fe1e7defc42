//! The facets and segments that are joined for the sizes. [`crate::joining`] finds them.

/// The flats and lines of a domain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flats {
    /// For each facet, the first facet of its flat.
    pub flats: Vec<u32>,
    /// For each segment, the first segment of its line. `None` for inner segments.
    pub lines: Vec<Option<u32>>,
    /// Whether each corner is a joint.
    pub joints: Vec<bool>,
    /// Corners of inner segments and of lines of several segments, with the length of the shortest segment there.
    pub spacing: Vec<(u32, f64)>,
    /// The tolerance t, in the coordinates of the domain.
    pub tolerance: f64,
}

impl Flats {
    /// Joins nothing.
    pub fn separate(corners: usize, segments: usize, facets: usize) -> Self {
        Flats {
            flats: (0..facets as u32).collect(),
            lines: (0..segments as u32).map(Some).collect(),
            joints: vec![false; corners],
            spacing: Vec::new(),
            tolerance: 0.0,
        }
    }

    /// Returns `true` if at least two facets or two segments are joined.
    pub fn is_joined(&self) -> bool {
        !self.spacing.is_empty()
    }

    /// Returns `true` if the segment lies inside a flat.
    pub fn is_inner(&self, segment: u32) -> bool {
        self.lines[segment as usize].is_none()
    }
}
