//! Complete lists of nearest points, one for each ball.

use septet_geometry::neighbourhood::NearestLists;

/// Owned points and their complete lists, in the order of completion.
#[derive(Clone, Debug, Default)]
pub(crate) struct CompletedLists {
    parts: Vec<Part>,
}

/// Owned points and their complete lists.
#[derive(Clone, Debug, Default)]
pub(crate) struct Part {
    points: Vec<u32>,
    nearest: NearestLists,
}

impl Part {
    /// Creates an empty part with capacity for `lists` lists of `items` items in total.
    pub(crate) fn with_capacity(lists: usize, items: usize) -> Self {
        Part { points: Vec::with_capacity(lists), nearest: NearestLists::with_capacity(lists, items) }
    }

    /// Adds the list of an owned point.
    pub(crate) fn push(&mut self, point: u32, kth2: f64, list: impl IntoIterator<Item = u32>) {
        self.points.push(point);
        self.nearest.push(kth2, list);
    }
}

/// The complete list of an owned point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest<'a> {
    pub(crate) point: u32,
    /// The squared distance to the last point wanted; infinite if the list has fewer points.
    pub(crate) kth2: f64,
    /// The nearest points.
    pub(crate) list: &'a [u32],
}

impl CompletedLists {
    /// Returns the number of lists.
    pub(crate) fn len(&self) -> usize {
        self.parts.iter().map(|part| part.points.len()).sum()
    }

    /// Adds a part.
    pub(crate) fn add_part(&mut self, part: Part) {
        self.parts.push(part);
    }

    /// Adds the list of an owned point to the last part.
    pub(crate) fn push(&mut self, point: u32, kth2: f64, list: impl IntoIterator<Item = u32>) {
        if self.parts.is_empty() {
            self.parts.push(Part::default());
        }
        if let Some(last) = self.parts.last_mut() {
            last.push(point, kth2, list);
        }
    }

    /// Returns the lists, in the order of completion.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Nearest<'_>> {
        let numbered = self.parts.iter().flat_map(|part| part.points.iter().zip(part.nearest.iter()));
        numbered.map(|(&point, (kth2, list))| Nearest { point, kth2, list })
    }

    /// Lowers the squared radii of owned points to the squared distances that their balls found.
    pub(crate) fn shrink(&self, radii2: &mut [f64]) {
        for nearest in self.iter() {
            let radius2 = &mut radii2[nearest.point as usize];
            *radius2 = radius2.min(nearest.kth2);
        }
    }

    /// Returns the nearest points of each of the owned points `0..owned_len`. A point without a list has an empty
    /// slice.
    pub(crate) fn by_owned(&self, owned_len: u32) -> Vec<&[u32]> {
        let mut lists = vec![&[][..]; owned_len as usize];
        for nearest in self.iter() {
            lists[nearest.point as usize] = nearest.list;
        }
        lists
    }
}
