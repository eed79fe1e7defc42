//! Text in UTF-16 with a mark of its byte order, as spreadsheets and loggers write it.

/// Whether bytes begin with a mark of UTF-16.
pub(super) fn has_mark(data: &[u8]) -> bool {
    data.starts_with(b"\xff\xfe") || data.starts_with(b"\xfe\xff")
}

/// Returns text in UTF-8 if the bytes are text in UTF-16 with a mark, otherwise the bytes. Text with damaged characters or
/// control characters stays as it is.
pub(super) fn decoded(data: Vec<u8>) -> Vec<u8> {
    if !has_mark(&data) || !data.len().is_multiple_of(2) {
        return data;
    }
    let is_big = data[0] == 0xfe;
    let unit = |pair: &[u8]| {
        let pair = [pair[0], pair[1]];
        if is_big { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
    };
    let units = data[2..].chunks_exact(2).map(unit);
    let is_text = |c: char| !c.is_control() || c.is_ascii_whitespace();
    let text: Option<String> = char::decode_utf16(units).map(|c| c.ok().filter(|c| is_text(*c))).collect();
    text.map_or(data, String::into_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders_are_decoded() {
        let text = "x;y\r\n1,5;é\u{1f600}\n";
        let units: Vec<u16> = std::iter::once(0xfeff).chain(text.encode_utf16()).collect();
        let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
        assert_eq!(decoded(little.clone()), text.as_bytes());
        assert_eq!(decoded(big), text.as_bytes());
        for damaged in [&little[..little.len() - 1], b"\xff\xfe\x00\xd8", b"\xff\xfe\x00\x00", b"1 2", b""] {
            assert_eq!(decoded(damaged.to_vec()), damaged);
        }
    }
}
