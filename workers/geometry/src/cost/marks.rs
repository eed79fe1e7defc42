//! Sets of small numbers, in storage that need not be cleared between two of them.

/// Which numbers have been seen, in storage that need not be cleared.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    round: u32,
    marks: Vec<u32>,
}

impl Marks {
    /// Marks for the numbers below `places`, and for [`u32::MAX`].
    pub fn new(places: usize) -> Self {
        Marks { round: 0, marks: vec![0; places + 1] }
    }

    /// Marks for the numbers below `places`, if there were fewer.
    pub fn make_room(&mut self, places: usize) {
        if places >= self.marks.len() {
            self.marks.resize(places + 1, 0);
        }
    }

    /// Nothing has been seen.
    pub fn begin(&mut self) {
        if self.round == u32::MAX {
            self.marks.fill(0);
            self.round = 0;
        }
        self.round += 1;
    }

    /// Has a number been seen?
    #[inline]
    pub fn has_seen(&self, number: u32) -> bool {
        self.marks[number.wrapping_add(1) as usize] == self.round
    }

    /// Sees a number; is it new?
    #[inline]
    pub fn is_new(&mut self, number: u32) -> bool {
        std::mem::replace(&mut self.marks[number.wrapping_add(1) as usize], self.round) != self.round
    }
}

/// The places of numbers among some of them, in storage that need not be cleared.
#[derive(Clone, Debug, Default)]
pub struct Places {
    pub(super) marks: Marks,
    places: Vec<u32>,
}

impl Places {
    /// Places for the numbers below `numbers`, and for [`u32::MAX`], if there were fewer.
    pub fn make_room(&mut self, numbers: usize) {
        self.marks.make_room(numbers);
    }

    /// Distinct numbers have the places of their order.
    pub(super) fn number(&mut self, distinct: &[u32]) {
        self.places.resize(self.marks.marks.len(), 0);
        for (place, &number) in (0..).zip(distinct) {
            self.places[number.wrapping_add(1) as usize] = place;
        }
    }

    /// The place of a number that has one.
    pub(super) fn of(&self, number: u32) -> u32 {
        self.places[number.wrapping_add(1) as usize]
    }
}
