//! The lists that balls of home points bring back.

use septet_geometry::neighbourhood::NearestLists;

/// Home points and their lists, in parts as they were completed.
#[derive(Clone, Debug, Default)]
pub(crate) struct CompletedLists {
    pub(crate) parts: Vec<Part>,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Part {
    owned_points: Vec<u32>,
    nearest: NearestLists,
}

impl Part {
    /// No lists, with room for so many of so many items in all.
    pub(crate) fn with_capacity(lists: usize, items: usize) -> Self {
        Part { owned_points: Vec::with_capacity(lists), nearest: NearestLists::with_capacity(lists, items) }
    }

    pub(crate) fn push(&mut self, owned: u32, kth2: f64, list: impl IntoIterator<Item = u32>) {
        self.owned_points.push(owned);
        self.nearest.push(kth2, list);
    }
}

impl CompletedLists {
    /// Number of lists.
    pub(crate) fn len(&self) -> usize {
        self.parts.iter().map(|part| part.owned_points.len()).sum()
    }

    /// A list that is complete, in the last part.
    pub(crate) fn push(&mut self, owned: u32, kth2: f64, list: impl IntoIterator<Item = u32>) {
        if self.parts.is_empty() {
            self.parts.push(Part::default());
        }
        if let Some(last) = self.parts.last_mut() {
            last.push(owned, kth2, list);
        }
    }

    /// In the order in which they were complete: home point, squared distance of the last one wanted, infinite if there
    /// are fewer, and the nearest.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, f64, &[u32])> {
        let numbered = self.parts.iter().flat_map(|part| part.owned_points.iter().zip(part.nearest.iter()));
        numbered.map(|(&owned, (kth2, list))| (owned, kth2, list))
    }

    /// Lowers squared radii of home points to what their balls found.
    pub(crate) fn shrink(&self, radii2: &mut [f64]) {
        for (owned, kth2, _) in self.iter() {
            let radius2 = &mut radii2[owned as usize];
            *radius2 = radius2.min(kth2);
        }
    }

    /// Of the home points `0..owned_points`, in that order, the nearest.
    pub(crate) fn by_owned(&self, owned_points: u32) -> Vec<&[u32]> {
        let mut lists = vec![&[][..]; owned_points as usize];
        for (owned, _, list) in self.iter() {
            lists[owned as usize] = list;
        }
        lists
    }
}
