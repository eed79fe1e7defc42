//! The groups of elements: regions and markers, with names and with positive tags.

use septet_core::model::Labels;

/// What a group consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Cells.
    Region,
    /// Triangles on facets, or edges on segments in the plane.
    Marker,
    /// Edges on segments in space.
    Segment,
}

/// Returns the number of the region of each cell: its attribute, if all attributes are whole numbers of 32 bits,
/// otherwise the number of its component.
pub fn region_numbers(labels: &Labels) -> Vec<i64> {
    let is_whole = |x: &f64| x.fract() == 0.0 && x.abs() <= f64::from(i32::MAX);
    if labels.attributes.iter().all(is_whole) {
        labels.attributes.iter().map(|&attribute| attribute as i64).collect()
    } else {
        labels.regions.iter().map(|&component| i64::from(component)).collect()
    }
}

/// The groups of the elements of one dimension.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Groups {
    kind: Kind,
    /// The numbers, ascending.
    numbers: Vec<i64>,
    /// A positive tag for each number.
    tags: Vec<u32>,
}

impl Groups {
    /// Collects the groups of elements with these numbers. The tag of a positive number of 31 bits is the number. Other
    /// numbers get tags above all these, because many programs have no group 0.
    pub(super) fn of(kind: Kind, numbers: &[i64]) -> Self {
        let mut numbers = numbers.to_vec();
        numbers.sort_unstable();
        numbers.dedup();
        let own = |number: i64| u32::try_from(number).ok().filter(|&tag| (1..=LARGEST).contains(&tag));
        let mut next = numbers.iter().filter_map(|&number| own(number)).max().unwrap_or(0);
        let tag = |&number: &i64| {
            own(number).unwrap_or_else(|| {
                next += 1;
                next
            })
        };
        let tags = numbers.iter().map(tag).collect();
        Groups { kind, numbers, tags }
    }

    /// Returns the number of groups.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Returns the position of the group of a number, which some element has.
    pub fn position(&self, number: i64) -> usize {
        self.numbers.binary_search(&number).unwrap_or(0)
    }

    /// Returns the positive tag of the group at a position.
    pub fn tag(&self, position: usize) -> u32 {
        self.tags[position]
    }

    /// Returns the name of the group at a position, such as `region-10`.
    pub fn name(&self, position: usize) -> String {
        let stem = match self.kind {
            Kind::Region => "region",
            Kind::Marker => "marker",
            Kind::Segment => "segment",
        };
        format!("{stem}-{}", self.numbers[position])
    }
}

/// The largest number that is its own tag. Above it, there is room for the tags of other numbers.
const LARGEST: u32 = 1 << 30;
