//! Parses the numbers of points of a sweep from the command line.

use septet_core::Remedy;
use thiserror::Error;

/// A list of sizes that cannot be parsed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("cannot read the sizes `{text}`: {reason}")]
pub struct SizesError {
    /// The list.
    pub text: String,
    /// The reason.
    pub reason: String,
}

impl SizesError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(Remedy::of("write 2^10..2^20, 2^10..2^20,per-octave=8 or 1000,2000,1e4"))
    }
}

/// Largest number of sizes in one sweep.
const MOST: usize = 10_000;

/// Parses sizes: numbers (`1000`, `1e6`, `2^20`) and ranges `A..B`. A range includes both ends. The part `per-octave=K`
/// sets the number of sizes per doubling in all ranges; without it, there is one. The sizes of a range are evenly
/// spaced on a logarithmic scale and rounded. The result is ascending, without repetitions.
///
/// # Errors
/// Fails if a part cannot be parsed, or if a range descends or starts at 0. The error contains the part.
pub fn parse_sizes(text: &str) -> Result<Vec<u64>, SizesError> {
    let fail = |reason: String| SizesError { text: text.to_string(), reason };
    let (mut ranges, mut sizes, mut steps) = (Vec::new(), Vec::new(), 1u32);
    for part in text.split(',').map(str::trim) {
        let number =
            |word: &str| number(word).ok_or_else(|| fail(format!("`{word}` is not a number of points")));
        if let Some(count) = part.strip_prefix("per-octave=") {
            let parsed = count.parse().ok().filter(|&k| (1..=64).contains(&k));
            steps = parsed.ok_or_else(|| fail("per-octave is a number from 1 to 64".to_string()))?;
        } else if let Some((from, to)) = part.split_once("..") {
            ranges.push((number(from)?, number(to)?));
        } else {
            sizes.push(number(part)?);
        }
    }
    for (from, to) in ranges {
        if from == 0 || from > to {
            return Err(fail(format!("the range from {from} to {to} is empty")));
        }
        let ratio = |i: u32| (from as f64 * (f64::from(i) / f64::from(steps)).exp2()).round() as u64;
        sizes.extend((0..).map(ratio).take_while(|&n| n <= to));
        sizes.push(to);
    }
    sizes.sort_unstable();
    sizes.dedup();
    match sizes.first() {
        None | Some(0) => Err(fail("a size is at least 1".to_string())),
        _ if sizes.len() > MOST => Err(fail(format!("{} sizes are too many", sizes.len()))),
        _ => Ok(sizes),
    }
}

/// Parses a whole number such as `1000`, `1e6` or `2^20`.
fn number(word: &str) -> Option<u64> {
    if let Some((base, power)) = word.split_once('^') {
        return base.parse::<u64>().ok()?.checked_pow(power.parse().ok()?);
    }
    match word.split_once(['e', 'E']) {
        Some((mantissa, power)) => {
            mantissa.parse::<u64>().ok()?.checked_mul(10u64.checked_pow(power.parse().ok()?)?)
        }
        None => word.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_lists() {
        assert_eq!(parse_sizes("2^10..2^13").unwrap(), [1024, 2048, 4096, 8192]);
        assert_eq!(parse_sizes("1000,1e4, 500").unwrap(), [500, 1000, 10_000]);
        let fine = parse_sizes("2^10..2^12,per-octave=4").unwrap();
        assert_eq!(fine, [1024, 1218, 1448, 1722, 2048, 2435, 2896, 3444, 4096]);
        assert_eq!(parse_sizes("2^10..2^20,per-octave=8").unwrap().len(), 81);
        assert_eq!(parse_sizes("1000..1500").unwrap(), [1000, 1500]);
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        for (text, word) in [
            ("", "``"),
            ("2^x", "`2^x`"),
            ("10..", "``"),
            ("20..10", "empty"),
            ("0", "at least 1"),
            ("2^99", "`2^99`"),
            ("1..2,per-octave=0", "per-octave"),
        ] {
            let error = parse_sizes(text).unwrap_err();
            assert!(error.to_string().contains(word), "{text}: {error}");
        }
    }
}
