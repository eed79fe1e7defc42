//! What balls of home points found, once nothing more can come.

use septet_geometry::neighbourhood::NearestLists;

/// Home points and what they found, in parts as they were completed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Done {
    pub(crate) parts: Vec<Part>,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Part {
    homes: Vec<u32>,
    nearest: NearestLists,
}

impl Part {
    /// No lists, with room for so many of so many items in all.
    pub(crate) fn with_capacity(lists: usize, items: usize) -> Self {
        Part { homes: Vec::with_capacity(lists), nearest: NearestLists::with_capacity(lists, items) }
    }

    pub(crate) fn push(&mut self, home: u32, kth2: f64, list: impl IntoIterator<Item = u32>) {
        self.homes.push(home);
        self.nearest.push(kth2, list);
    }
}

impl Done {
    /// Number of lists.
    pub(crate) fn len(&self) -> usize {
        self.parts.iter().map(|part| part.homes.len()).sum()
    }

    /// A list that is complete, in the last part.
    pub(crate) fn push(&mut self, home: u32, kth2: f64, list: impl IntoIterator<Item = u32>) {
        if self.parts.is_empty() {
            self.parts.push(Part::default());
        }
        if let Some(last) = self.parts.last_mut() {
            last.push(home, kth2, list);
        }
    }

    /// In the order in which they were complete: home point, squared distance of the last one wanted, infinite if there
    /// are fewer, and the nearest.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, f64, &[u32])> {
        let numbered = self.parts.iter().flat_map(|part| part.homes.iter().zip(part.nearest.iter()));
        numbered.map(|(&home, (kth2, list))| (home, kth2, list))
    }

    /// Of the home points `0..homes`, in that order, the nearest.
    pub(crate) fn by_home(&self, homes: u32) -> Vec<&[u32]> {
        let mut lists = vec![&[][..]; homes as usize];
        for (home, _, list) in self.iter() {
            lists[home as usize] = list;
        }
        lists
    }
}
