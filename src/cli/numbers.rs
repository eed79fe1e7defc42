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

/// Parses a number of bytes; K, M, G and T stand for powers of 1024.
pub fn bytes(text: &str) -> Result<u64, String> {
    let text = text.strip_suffix(['B', 'b']).unwrap_or(text);
    let text = text.strip_suffix('i').unwrap_or(text);
    let (digits, shift) = match text.char_indices().next_back() {
        Some((at, 'k' | 'K')) => (&text[..at], 10),
        Some((at, 'm' | 'M')) => (&text[..at], 20),
        Some((at, 'g' | 'G')) => (&text[..at], 30),
        Some((at, 't' | 'T')) => (&text[..at], 40),
        _ => (text, 0),
    };
    let value = digits.parse::<f64>().ok().filter(|v| *v >= 0.0 && v.is_finite());
    let value = value.ok_or_else(|| "expected a number of bytes, such as 500M or 2G".to_owned())?;
    Ok((value * (1u64 << shift) as f64) as u64)
}
