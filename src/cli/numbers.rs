//! Numbers on the command line.

/// Parses a whole number, possibly with an exponent.
pub fn count(text: &str) -> Result<u64, String> {
    let parsed = match text.split_once(['e', 'E']) {
        None => text.parse().ok(),
        Some((mantissa, exponent)) => exponent
            .parse()
            .ok()
            .and_then(|e| 10u64.checked_pow(e))
            .and_then(|power| mantissa.parse::<u64>().ok()?.checked_mul(power)),
    };
    parsed.ok_or_else(|| "expected a whole number, such as 1000 or 1e6".to_owned())
}
