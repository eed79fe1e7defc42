//! Many lists in one block of memory.
//!
//! **Statement.** The items of all lists lie in one vector, list after list. A list therefore needs no allocation of
//! its own.

use std::ops::Index;

/// Lists, in the order in which they were added.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lists<T> {
    items: Vec<T>,
    /// For each list, the position behind its last item.
    ends: Vec<usize>,
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Lists { items: Vec::new(), ends: Vec::new() }
    }
}

impl<T> Lists<T> {
    /// Creates an empty collection with room for `lists` lists and `items` items in total.
    pub fn with_capacity(lists: usize, items: usize) -> Self {
        Lists { items: Vec::with_capacity(items), ends: Vec::with_capacity(lists) }
    }

    /// Creates empty lists.
    pub fn of_empty(lists: usize) -> Self {
        Lists { items: Vec::new(), ends: vec![0; lists] }
    }

    /// Returns the bytes that hold the lists.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.items[..]) + size_of_val(&self.ends[..])) as u64
    }

    /// Returns the number of items in all lists.
    pub fn items(&self) -> usize {
        self.items.len()
    }

    /// Returns the number of lists.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns `true` if there are no lists.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Appends a list.
    #[inline]
    pub fn push(&mut self, list: impl IntoIterator<Item = T>) {
        self.items.extend(list);
        self.ends.push(self.items.len());
    }

    /// Appends a list that is the concatenation of two parts.
    #[inline]
    pub fn push_two(&mut self, first: &[T], second: impl IntoIterator<Item = T>)
    where
        T: Copy,
    {
        self.items.extend_from_slice(first);
        self.push(second);
    }

    /// Appends all lists of another collection.
    pub fn append(&mut self, mut other: Lists<T>) {
        let before = self.items.len();
        self.items.append(&mut other.items);
        self.ends.extend(other.ends.into_iter().map(|end| before + end));
    }

    /// Returns all items, list after list.
    pub fn into_items(self) -> Vec<T> {
        self.items
    }

    /// Iterates over the lists, in order.
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
    fn lists_are_stored_consecutively() {
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
