//! Base64 as VTK files use it: several padded runs may follow each other.

/// Decodes the text up to the first byte that is neither base64 nor whitespace. Returns `None` if a run is
/// incomplete.
pub fn decode(text: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let mut quad = [0_u8; 4];
    let (mut filled, mut padding) = (0, 0);
    for byte in text {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' => {
                padding += 1;
                0
            }
            _ if byte.is_ascii_whitespace() => continue,
            _ => break,
        };
        if padding > 0 && *byte != b'=' {
            return None;
        }
        quad[filled] = value;
        filled += 1;
        if filled == 4 {
            let all = quad.iter().fold(0_u32, |all, six| all << 6 | u32::from(*six));
            let kept = 3_usize.checked_sub(padding).filter(|kept| *kept > 0)?;
            bytes.extend_from_slice(&all.to_be_bytes()[1..=kept]);
            (filled, padding) = (0, 0);
        }
    }
    (filled == 0).then_some(bytes)
}
