//! Many lists that grow by parts as answers come, in one block: no list costs an allocation.

use septet_geometry::complex::NONE;

/// Where a list begins and where its last part is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chain {
    first: u32,
    last: u32,
}

impl Chain {
    /// An empty list.
    pub(crate) const EMPTY: Chain = Chain { first: NONE, last: NONE };
}

/// The parts of all lists: numbers, and for each part where it begins, its length, and the part that follows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chains {
    numbers: Vec<u32>,
    parts: Vec<(usize, u32, u32)>,
}

impl Chains {
    /// Makes room for more parts of so many numbers in all.
    pub(crate) fn reserve(&mut self, parts: usize, numbers: usize) {
        self.parts.reserve(parts);
        self.numbers.reserve(numbers);
    }

    /// Adds a part to a list.
    pub(crate) fn add(&mut self, chain: &mut Chain, part: impl IntoIterator<Item = u32>) {
        let begin = self.numbers.len();
        self.numbers.extend(part);
        let len = (self.numbers.len() - begin) as u32;
        if len == 0 {
            return;
        }
        let at = self.parts.len() as u32;
        self.parts.push((begin, len, NONE));
        match self.parts.get_mut(chain.last as usize) {
            Some(last) => last.2 = at,
            None => chain.first = at,
        }
        chain.last = at;
    }

    /// The numbers of a list in the order in which they came.
    pub(crate) fn iter(&self, chain: Chain) -> impl Iterator<Item = u32> {
        let mut at = chain.first;
        let parts = std::iter::from_fn(move || {
            let &(begin, len, next) = self.parts.get(at as usize)?;
            at = next;
            Some(&self.numbers[begin..begin + len as usize])
        });
        parts.flatten().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_keep_their_parts_in_order() {
        let mut chains = Chains::default();
        let [mut a, mut b, c] = [Chain::EMPTY; 3];
        chains.add(&mut a, [1, 2]);
        chains.add(&mut b, [7]);
        chains.add(&mut a, []);
        chains.add(&mut a, [3]);
        chains.add(&mut b, [8, 9]);
        let all = |chain| chains.iter(chain).collect::<Vec<_>>();
        assert_eq!((all(a), all(b), all(c)), (vec![1, 2, 3], vec![7, 8, 9], vec![]));
    }
}
