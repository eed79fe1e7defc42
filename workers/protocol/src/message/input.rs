//! The survey of the rows of an input, before they are prepared.

use bincode::{Decode, Encode};
use septet_geometry::range::{Digits, RangeError};

/// A row with a coordinate that is not finite. Two of them are equal if the bits of the coordinates are.
#[derive(Clone, Copy, Debug, Encode, Decode)]
pub struct RefusedRow {
    /// The number of the row.
    pub row: u64,
    /// The coordinate.
    pub value: f64,
}

impl PartialEq for RefusedRow {
    fn eq(&self, other: &Self) -> bool {
        (self.row, self.value.to_bits()) == (other.row, other.value.to_bits())
    }
}

/// The survey of some rows of an input.
#[derive(Clone, Copy, Debug, PartialEq, Encode, Decode)]
pub struct Survey {
    /// Number of rows.
    pub rows: u64,
    /// The smallest number of a row; `u64::MAX` for no rows.
    pub first: u64,
    /// The largest number of a row; 0 for no rows.
    pub last: u64,
    /// Number of rows with a coordinate that is not finite.
    pub refused: u64,
    /// The first of these rows.
    pub first_refused: Option<RefusedRow>,
    /// Number of coordinates that are -0.0.
    pub negative_zeros: u64,
    /// The digits of the other rows ([`Digits::ends`]).
    pub digits: (i32, i32),
    /// The first row that uses the lowest digit, if the digits are exact.
    pub lowest_row: u64,
    /// The last row that uses the highest digit, if the digits are exact.
    pub highest_row: u64,
}

impl Default for Survey {
    fn default() -> Self {
        Survey {
            rows: 0,
            first: u64::MAX,
            last: 0,
            refused: 0,
            first_refused: None,
            negative_zeros: 0,
            digits: Digits::NONE.ends(),
            lowest_row: 0,
            highest_row: 0,
        }
    }
}

impl Survey {
    /// Returns the survey of two disjoint sets of rows.
    #[must_use]
    pub fn join(self, other: Survey) -> Self {
        let refused = [self.first_refused, other.first_refused].into_iter().flatten();
        let (lowest, highest) = (
            (self.digits.0, self.lowest_row).min((other.digits.0, other.lowest_row)),
            (self.digits.1, self.highest_row).max((other.digits.1, other.highest_row)),
        );
        Survey {
            rows: self.rows + other.rows,
            first: self.first.min(other.first),
            last: self.last.max(other.last),
            refused: self.refused + other.refused,
            first_refused: refused.min_by_key(|refused| refused.row),
            negative_zeros: self.negative_zeros + other.negative_zeros,
            digits: (lowest.0, highest.0),
            lowest_row: lowest.1,
            highest_row: highest.1,
        }
    }

    /// Returns `true` if these rows may be some of the rows of another survey.
    pub fn is_part_of(&self, all: &Survey) -> bool {
        self.rows <= all.rows
            && (self.rows == 0 || all.first <= self.first && self.last <= all.last)
            && self.digits.0 >= all.digits.0
            && self.digits.1 <= all.digits.1
    }

    /// Returns `true` if some rows must have the same number, because there are more rows than numbers between the smallest
    /// and the largest.
    pub fn repeats_numbers(&self) -> bool {
        self.rows > 0 && self.last.saturating_sub(self.first) < self.rows - 1
    }

    /// Returns `true` if the digits lie in the exact range.
    pub fn fits(&self) -> bool {
        Digits::new(self.digits).fits()
    }

    /// Returns the exponent of the power of two that scales the rows into the exact range. The digits must be exact unless
    /// they fit. If `skips` is set, rows that are not finite are removed.
    ///
    /// # Errors
    /// Fails if a row is not finite and `skips` is not set, or if the digits spread too far.
    pub fn exponent(&self, skips: bool) -> Result<i32, RangeError> {
        match self.first_refused {
            Some(RefusedRow { row, value }) if !skips => {
                Err(RangeError::NotFinite { index: row as usize, value })
            }
            _ => Digits::new(self.digits).scaling().map_err(|bits| RangeError::Spread {
                bits,
                low: self.lowest_row as usize,
                high: self.highest_row as usize,
            }),
        }
    }
}

/// The sites of some ranks: points with weights.
#[derive(Clone, Copy, Debug, PartialEq, Encode, Decode)]
pub struct SiteTotals {
    /// The largest weight; negative infinity without sites.
    pub heaviest: f64,
    /// Number of hidden sites: of those under a heavier site at the same position, or of all others.
    pub hidden: u64,
}

impl Default for SiteTotals {
    fn default() -> Self {
        SiteTotals { heaviest: f64::NEG_INFINITY, hidden: 0 }
    }
}

impl SiteTotals {
    /// Returns the totals of two disjoint sets of sites.
    #[must_use]
    pub fn join(self, other: SiteTotals) -> Self {
        SiteTotals { heaviest: self.heaviest.max(other.heaviest), hidden: self.hidden + other.hidden }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surveys_name_the_outermost_rows() {
        let row = |row: u64, digits| Survey {
            rows: 1,
            first: row,
            last: row,
            digits,
            lowest_row: row,
            highest_row: row,
            ..Survey::default()
        };
        let bad = |row: u64| Survey {
            rows: 1,
            first: row,
            last: row,
            refused: 1,
            first_refused: Some(RefusedRow { row, value: f64::INFINITY }),
            ..Survey::default()
        };
        let rows =
            [row(0, (-300, 2)), row(1, (-300, 5)), bad(2), row(3, (200, 203)), bad(4), row(5, (0, 203))];
        for order in [[0, 1, 2, 3, 4, 5], [5, 4, 3, 2, 1, 0], [3, 0, 5, 1, 4, 2]] {
            let all = order.into_iter().map(|i| rows[i]).fold(Survey::default(), Survey::join);
            assert_eq!((all.rows, all.refused, all.digits), (6, 2, (-300, 203)));
            assert_eq!((all.first, all.last), (0, 5));
            assert!(!all.repeats_numbers() && all.join(row(5, (0, 0))).repeats_numbers());
            assert!(!all.join(row(9, (0, 0))).repeats_numbers());
            let refused = RangeError::NotFinite { index: 2, value: f64::INFINITY };
            assert_eq!(all.exponent(false), Err(refused));
            assert_eq!(all.exponent(true), Err(RangeError::Spread { bits: 503, low: 0, high: 5 }));
        }
        assert!(
            !Survey::default().repeats_numbers() && !row(7, (0, 0)).join(Survey::default()).repeats_numbers()
        );
        let nan = || Survey { first_refused: Some(RefusedRow { row: 1, value: f64::NAN }), ..bad(1) };
        assert!(nan() == nan() && nan() != bad(1));
        assert_eq!(Survey::default().exponent(false), Ok(0));
        assert!(row(0, (-300, -200)).exponent(false).unwrap() > 0);
    }
}
