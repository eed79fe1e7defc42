//! Writes streams of records, which are formatted in parallel and written in order.

use std::io::{self, Write};
use std::ops::Range;

use septet_core::cores::map_blocks;

/// The number of records per unit of parallel work. It is fixed, so that the bytes do not depend on the computer.
const CHUNK: usize = 4096;

/// The number of units that are formatted before they are written. It limits the memory for their text.
const BATCH: usize = 64;

/// Counts the records written, and reports the count.
pub(super) struct WriteProgress<'a> {
    done: u64,
    total: u64,
    report: &'a mut dyn FnMut(u64, u64),
}

impl<'a> WriteProgress<'a> {
    /// Creates a counter for `total` records, none of which is written yet.
    pub(super) fn new(total: u64, report: &'a mut dyn FnMut(u64, u64)) -> Self {
        report(0, total);
        Self { done: 0, total, report }
    }

    /// Adds `count` records.
    pub(super) fn advance(&mut self, count: u64) {
        self.done = (self.done + count).min(self.total);
        (self.report)(self.done, self.total);
    }

    /// Reports the total. The count may be lower if the total is an estimate.
    pub(super) fn finish(mut self) {
        let rest = self.total - self.done;
        if rest > 0 {
            self.advance(rest);
        }
    }
}

/// Writes records `0..count`. `format` appends a record to a buffer.
pub(super) fn write_records(
    out: &mut dyn Write,
    count: usize,
    progress: &mut WriteProgress<'_>,
    format: impl Fn(&mut Vec<u8>, usize) + Sync,
) -> io::Result<()> {
    write_range(out, 0..count, progress, format)
}

/// Writes the records of a range. `format` appends a record to a buffer.
pub(super) fn write_range(
    out: &mut dyn Write,
    range: Range<usize>,
    progress: &mut WriteProgress<'_>,
    format: impl Fn(&mut Vec<u8>, usize) + Sync,
) -> io::Result<()> {
    let mut start = range.start;
    while start < range.end {
        let end = range.end.min(start + CHUNK * BATCH);
        let chunks = map_blocks(end - start, CHUNK, |block| {
            let mut buffer = Vec::new();
            block.for_each(|index| format(&mut buffer, start + index));
            buffer
        });
        for chunk in chunks {
            out.write_all(&chunk)?;
        }
        progress.advance((end - start) as u64);
        start = end;
    }
    Ok(())
}

/// Appends a number in decimal digits.
pub(super) fn push_integer(buffer: &mut Vec<u8>, mut value: u64) {
    let mut digits = [0u8; 20];
    let mut start = digits.len();
    loop {
        start -= 1;
        digits[start] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    buffer.extend_from_slice(&digits[start..]);
}

/// Appends a space and a signed integer.
pub(super) fn push_signed(buffer: &mut Vec<u8>, value: i64) {
    buffer.extend_from_slice(if value < 0 { b" -" } else { b" " });
    push_integer(buffer, value.unsigned_abs());
}

/// Appends the shortest decimal form that reads back as the same double. Very small and very large numbers get an
/// exponent.
pub(super) fn push_float(buffer: &mut Vec<u8>, value: f64) {
    let size = value.abs();
    // Writing to a vector cannot fail.
    let _ = if size == 0.0 || (1e-3..1e17).contains(&size) {
        write!(buffer, "{value}")
    } else {
        write!(buffer, "{value:e}")
    };
}

/// Appends a decimal form of a number that has at most this many characters, at least 12. It reads back as the
/// same double if the shortest form fits.
pub(super) fn push_float_within(buffer: &mut Vec<u8>, value: f64, most: usize) {
    let start = buffer.len();
    push_float(buffer, value);
    // A digit less until it fits: -1.2e-308 has 9 characters.
    let mut digits = 17;
    while buffer.len() - start > most && digits > 0 {
        digits -= 1;
        buffer.truncate(start);
        // Writing to a vector cannot fail.
        let _ = write!(buffer, "{value:.digits$e}");
    }
}

/// Appends the coordinates of a point with a separator between them. If `space` is set, a point in the plane gets z =
/// 0.
pub(super) fn push_point(buffer: &mut Vec<u8>, point: &[f64], separator: u8, space: bool) {
    for (axis, &coordinate) in point.iter().enumerate() {
        if axis > 0 {
            buffer.push(separator);
        }
        push_float(buffer, coordinate);
    }
    if space && point.len() == 2 {
        buffer.push(separator);
        buffer.push(b'0');
    }
}

/// Appends each index plus `base`, preceded by a space.
pub(super) fn push_indices(buffer: &mut Vec<u8>, indices: &[u64], base: u64) {
    for &index in indices {
        buffer.push(b' ');
        push_integer(buffer, index + base);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn float(value: f64) -> String {
        let mut buffer = Vec::new();
        push_float(&mut buffer, value);
        String::from_utf8(buffer).unwrap()
    }

    #[test]
    fn floats_are_short() {
        assert_eq!(float(0.1), "0.1");
        assert_eq!(float(-2.0), "-2");
        assert_eq!(float(0.0), "0");
        assert_eq!(float(-0.0), "-0");
        assert_eq!(float(1e-120), "1e-120");
        assert_eq!(float(-1.5e200), "-1.5e200");
        assert_eq!(float(5e-324), "5e-324");
        assert_eq!(float(f64::MAX), "1.7976931348623157e308");
    }

    #[test]
    fn floats_fit_into_their_fields() {
        let within = |value: f64, most: usize| {
            let mut buffer = Vec::new();
            push_float_within(&mut buffer, value, most);
            String::from_utf8(buffer).unwrap()
        };
        assert_eq!(within(0.1, 15), "0.1");
        assert_eq!(within(1.0 / 3.0, 20), "0.3333333333333333");
        assert_eq!(within(-1.234_567_890_123_456_7e-5, 20), "-1.23456789012346e-5");
        assert_eq!(within(-f64::MAX, 15), "-1.79769313e308");
        assert_eq!(within(1.0 / 3.0, 15), "3.3333333333e-1");
    }

    proptest::proptest! {
        #[test]
        fn floats_read_back_bit_for_bit(bits in proptest::num::u64::ANY) {
            let value = f64::from_bits(bits);
            if value.is_finite() {
                let text = float(value);
                proptest::prop_assert_eq!(text.parse::<f64>().unwrap().to_bits(), bits);
                proptest::prop_assert!(text.len() <= 24, "{}", text);
            }
        }

        #[test]
        fn integers_are_decimal(value in proptest::num::u64::ANY) {
            let mut buffer = Vec::new();
            push_integer(&mut buffer, value);
            proptest::prop_assert_eq!(String::from_utf8(buffer).unwrap(), value.to_string());
        }
    }

    #[test]
    fn records_come_in_order_and_are_counted() {
        let count = CHUNK * BATCH * 2 + 17;
        let mut reports = Vec::new();
        let mut report = |done, total| reports.push((done, total));
        let mut progress = WriteProgress::new(count as u64, &mut report);
        let mut out = Vec::new();
        write_records(&mut out, count, &mut progress, |buffer, index| {
            push_integer(buffer, index as u64);
            buffer.push(b'\n');
        })
        .unwrap();
        progress.finish();
        let text = String::from_utf8(out).unwrap();
        assert!(text.lines().enumerate().all(|(i, line)| line == i.to_string()));
        assert_eq!(text.lines().count(), count);
        assert_eq!(reports.len(), 4);
        assert_eq!(reports[3], (count as u64, count as u64));
    }
}
