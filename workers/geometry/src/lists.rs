//! Lists of many items, one behind the other.
//!
//! **Statement.** The lists stand in one block of memory, so that a list costs no allocation of its own.

use std::ops::Index;

/// Lists in the order in which they were added.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lists<T> {
    items: Vec<T>,
    /// One past the last item of each list.
    ends: Vec<usize>,
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Lists { items: Vec::new(), ends: Vec::new() }
    }
}

impl<T> Lists<T> {
    /// No lists, with room for so many of so many items in all.
    pub fn with_capacity(lists: usize, items: usize) -> Self {
        Lists { items: Vec::with_capacity(items), ends: Vec::with_capacity(lists) }
    }

    /// Number of items in all lists.
    pub fn items(&self) -> usize {
        self.items.len()
    }

    /// Number of lists.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Is there no list?
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Adds a list.
    #[inline]
    pub fn push(&mut self, list: impl IntoIterator<Item = T>) {
        self.items.extend(list);
        self.ends.push(self.items.len());
    }

    /// Adds a list of two parts.
    #[inline]
    pub fn push_two(&mut self, first: &[T], second: impl IntoIterator<Item = T>)
    where
        T: Copy,
    {
        self.items.extend_from_slice(first);
        self.push(second);
    }

    /// Adds all lists of another.
    pub fn append(&mut self, mut other: Lists<T>) {
        let before = self.items.len();
        self.items.append(&mut other.items);
        self.ends.extend(other.ends.into_iter().map(|end| before + end));
    }

    /// All items, list by list.
    pub fn into_items(self) -> Vec<T> {
        self.items
    }

    /// All lists, in order.
    pub fn iter(&self) -> impl Iterator<Item = &[T]> + '_ {
        (0..self.len()).map(|at| &self[at])
    }
}

impl<T> Index<usize> for Lists<T> {
    type Output = [T];

    #[inline]
    fn index(&self, at: usize) -> &[T] {
        let start = if at == 0 { 0 } else { self.ends[at - 1] };
        &self.items[start..self.ends[at]]
    }
}

impl<T> FromIterator<Vec<T>> for Lists<T> {
    fn from_iter<I: IntoIterator<Item = Vec<T>>>(lists: I) -> Self {
        let mut all = Lists::default();
        lists.into_iter().for_each(|list| all.push(list));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_stand_one_behind_the_other() {
        let mut lists: Lists<u32> = [vec![1, 2], vec![], vec![3]].into_iter().collect();
        lists.append([vec![], vec![4, 5]].into_iter().collect());
        assert_eq!(lists.len(), 5);
        let all: Vec<&[u32]> = lists.iter().collect();
        assert_eq!(all, [&[1, 2][..], &[], &[3], &[], &[4, 5]]);
        assert_eq!((&lists[3], &lists[4]), (&[][..], &[4, 5][..]));
        lists.push_two(&[6], [7, 8]);
        assert_eq!((lists.len(), &lists[5]), (6, &[6, 7, 8][..]));
        assert_eq!(lists.into_items(), [1, 2, 3, 4, 5, 6, 7, 8]);
    }
}
