//! Histograms with equal bins, with counts of the values outside them, and with percentiles.
//!
//! **Statement.** A histogram is a function of the set of its values. It does not depend on their order, because it holds
//! counts, extremes and an exact sum. Histograms of parts of a set can therefore be made anywhere and merged.
//!
//! A percentile `p` is the smallest value that at least `p` percent of the values do not exceed. It comes from counts by the
//! leading `DIGITS` binary digits of the values, so it is too small by at most one part in 2048.

use std::collections::BTreeMap;

use crate::sum::ExactSum;

/// Binary digits after the first one that distinguish values for percentiles.
const DIGITS: u32 = 11;

/// The percentiles of reports.
pub const PERCENTILES: [u8; 7] = [1, 5, 25, 50, 75, 95, 99];

/// Counts of values in equal bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// The lower end of the first bin.
    pub from: f64,
    /// The upper end of the last bin.
    pub to: f64,
    /// The number of values in each bin. A bin includes its lower end and excludes its upper end.
    pub counts: Vec<u64>,
    /// The number of values below the first bin.
    pub below: u64,
    /// The number of values that are NaN, or at or above the end of the last bin.
    pub above: u64,
    /// The smallest value.
    pub least: f64,
    /// The largest value.
    pub most: f64,
    sum: ExactSum,
    /// For each sign and exponent, the counts by leading digits.
    fine: BTreeMap<u64, Vec<u64>>,
}

impl Histogram {
    /// Creates an empty histogram with `bins` equal bins.
    pub fn new(from: f64, to: f64, bins: usize) -> Self {
        let counts = vec![0; bins.max(1)];
        let (least, most) = (f64::INFINITY, f64::NEG_INFINITY);
        let (sum, fine) = (ExactSum::default(), BTreeMap::new());
        Histogram { from, to, counts, below: 0, above: 0, least, most, sum, fine }
    }

    /// Counts a value.
    pub fn add(&mut self, x: f64) {
        self.least = self.least.min(x);
        self.most = self.most.max(x);
        self.sum.add(x);
        let key = ordered(x.to_bits()) >> (52 - DIGITS);
        let row = self.fine.entry(key >> DIGITS).or_insert_with(|| vec![0; 1 << DIGITS]);
        row[(key & ((1 << DIGITS) - 1)) as usize] += 1;
        let at = (x - self.from) / (self.to - self.from) * self.counts.len() as f64;
        if x < self.from {
            self.below += 1;
        } else if let Some(count) = (x < self.to).then(|| self.counts.len() - 1) {
            self.counts[(at as usize).min(count)] += 1;
        } else {
            self.above += 1;
        }
    }

    /// Adds the values of a histogram with the same bins.
    pub fn merge(&mut self, other: &Histogram) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(own, other)| *own += other);
        self.below += other.below;
        self.above += other.above;
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
        self.sum.merge(&other.sum);
        for (key, row) in &other.fine {
            let own = self.fine.entry(*key).or_insert_with(|| vec![0; 1 << DIGITS]);
            own.iter_mut().zip(row).for_each(|(own, other)| *own += other);
        }
    }

    /// Returns the number of values.
    pub fn total(&self) -> u64 {
        self.below + self.above + self.counts.iter().sum::<u64>()
    }

    /// Returns the mean, or `None` if there are no values. It is NaN if a value is not finite.
    pub fn mean(&self) -> Option<f64> {
        let total = self.total();
        (total > 0).then(|| self.sum.value() / total as f64)
    }

    /// Returns a percentile, or `None` if there are no values. It is too small by at most one part in 2048, but not below
    /// the smallest value.
    pub fn percentile(&self, percent: u8) -> Option<f64> {
        let total = u128::from(self.total());
        let rank = (u128::from(percent) * total).div_ceil(100).clamp(1, total.max(1)) as u64;
        let mut seen = 0;
        for (high, row) in &self.fine {
            for (low, count) in (0..).zip(row) {
                seen += count;
                if seen >= rank {
                    let key = (high << DIGITS | low) << (52 - DIGITS);
                    return Some(f64::from_bits(unordered(key)).max(self.least).min(self.most));
                }
            }
        }
        None
    }

    /// Returns the ends of bin `i`.
    pub fn bin(&self, i: usize) -> [f64; 2] {
        let step = (self.to - self.from) / self.counts.len() as f64;
        [self.from + step * i as f64, self.from + step * (i + 1) as f64]
    }

    /// Appends the values to words, to be sent. The ends and the number of the bins are not among them.
    pub fn append_to(&self, words: &mut Vec<u64>) {
        words.extend(&self.counts);
        words.extend([self.below, self.above, self.least.to_bits(), self.most.to_bits()]);
        words.extend(self.sum.to_words());
        words.push(self.fine.len() as u64);
        for (key, row) in &self.fine {
            words.push(*key);
            words.extend(row);
        }
    }

    /// Takes the values of a histogram with the same bins from words. Returns `None` if there are too few.
    pub fn read_from(&self, words: &mut impl Iterator<Item = u64>) -> Option<Self> {
        let mut made = Histogram::new(self.from, self.to, self.counts.len());
        for count in &mut made.counts {
            *count = words.next()?;
        }
        (made.below, made.above) = (words.next()?, words.next()?);
        (made.least, made.most) = (f64::from_bits(words.next()?), f64::from_bits(words.next()?));
        made.sum = ExactSum::from_words(words)?;
        for _ in 0..words.next()? {
            let key = words.next()?;
            let row: Vec<u64> = words.by_ref().take(1 << DIGITS).collect();
            (row.len() == 1 << DIGITS).then_some(())?;
            made.fine.insert(key, row);
        }
        Some(made)
    }
}

/// The sign of a number.
const SIGN: u64 = 1 << 63;

/// Returns bits whose order is that of the numbers.
fn ordered(bits: u64) -> u64 {
    if bits & SIGN == 0 { bits | SIGN } else { !bits }
}

/// Returns the number with these ordered bits.
fn unordered(bits: u64) -> u64 {
    if bits & SIGN == 0 { !bits } else { bits & !SIGN }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(values: impl IntoIterator<Item = f64>) -> Histogram {
        let mut made = Histogram::new(0.0, 10.0, 5);
        values.into_iter().for_each(|x| made.add(x));
        made
    }

    /// The percentiles of several sets, by sorting.
    #[test]
    fn percentiles_are_those_of_the_sorted_values() {
        for n in [1usize, 2, 7, 100, 1001] {
            let mut values: Vec<f64> = (0..n).map(|i| ((i * 7919) % n) as f64 * 1.37 + 0.01).collect();
            let made = filled(values.iter().copied());
            values.sort_by(f64::total_cmp);
            for percent in PERCENTILES {
                let expected = values[(percent as usize * n).div_ceil(100) - 1];
                let found = made.percentile(percent).unwrap();
                assert!(found <= expected && found >= expected * (1.0 - 1.0 / 2048.0), "{found} {expected}");
            }
        }
        assert_eq!(filled([]).percentile(50), None);
        assert_eq!(filled([1.0 / 3.0]).percentile(99), Some(1.0 / 3.0));
        assert_eq!(filled([-2.0, 3.0, f64::INFINITY]).percentile(1), Some(-2.0));
        assert_eq!(filled([1.0, f64::INFINITY]).percentile(99), Some(f64::INFINITY));
    }

    #[test]
    fn parts_merge_to_the_whole_in_any_order() {
        let values: Vec<f64> = (0..500).map(|i| f64::from(i * 37 % 101) / 7.0).collect();
        let (low, high) = values.split_at(123);
        let whole = filled(values.iter().copied());
        let mut merged = filled(high.iter().rev().copied());
        merged.merge(&filled(low.iter().copied()));
        assert_eq!(merged, whole);
        let mut words = Vec::new();
        whole.append_to(&mut words);
        let mut read = words.iter().copied();
        assert_eq!(Histogram::new(0.0, 10.0, 5).read_from(&mut read), Some(whole));
        assert_eq!(read.next(), None);
        let cut = &mut words[..9].iter().copied();
        assert_eq!(Histogram::new(0.0, 10.0, 5).read_from(cut), None);
    }
}
