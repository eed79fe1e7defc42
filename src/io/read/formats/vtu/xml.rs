//! The subset of XML that VTK files use: tags and attributes, without entities.

/// A tag.
pub struct Tag<'a> {
    /// The name, without a slash.
    pub name: &'a [u8],
    attributes: &'a [u8],
    /// Whether the tag is `</name>`.
    pub closing: bool,
    /// Whether the tag is `<name/>`.
    pub empty: bool,
    /// The byte offset of its `<`.
    pub start: usize,
    /// The byte offset after its `>`.
    pub end: usize,
}

impl<'a> Tag<'a> {
    /// Returns the value of an attribute, without quotes.
    pub fn attribute(&self, wanted: &str) -> Option<&'a str> {
        let mut rest = self.attributes;
        loop {
            let equals = rest.iter().position(|b| *b == b'=')?;
            let name = rest[..equals].trim_ascii();
            let value = rest[equals + 1..].trim_ascii_start();
            let (quote, value) = value.split_first()?;
            if !matches!(quote, b'"' | b'\'') {
                return None;
            }
            let end = value.iter().position(|b| b == quote)?;
            if name == wanted.as_bytes() {
                return std::str::from_utf8(&value[..end]).ok();
            }
            rest = &value[end + 1..];
        }
    }
}

/// Returns the next tag at or after `from`. Comments and declarations are skipped.
pub fn next_tag(data: &[u8], mut from: usize) -> Option<Tag<'_>> {
    loop {
        let start = from + data.get(from..)?.iter().position(|b| *b == b'<')?;
        let rest = &data[start..];
        let skipped = match rest {
            [b'<', b'!', b'-', b'-', ..] => find(rest, b"-->")?,
            [b'<', b'?', ..] => find(rest, b"?>")?,
            [b'<', b'!', ..] => find(rest, b">")?,
            _ => return tag(data, start),
        };
        from = start + skipped;
    }
}

/// Returns the byte offset after the first `mark`.
fn find(data: &[u8], mark: &[u8]) -> Option<usize> {
    data.windows(mark.len()).position(|w| w == mark).map(|at| at + mark.len())
}

fn tag(data: &[u8], start: usize) -> Option<Tag<'_>> {
    let body = &data[start + 1..];
    let mut quote = None;
    let length = body.iter().position(|b| match (quote, b) {
        (None, b'>') => true,
        (None, b'"' | b'\'') => {
            quote = Some(*b);
            false
        }
        (Some(open), b) => {
            if open == *b {
                quote = None;
            }
            false
        }
        _ => false,
    })?;
    let body = &body[..length];
    let (closing, body) = body.strip_prefix(b"/").map_or((false, body), |body| (true, body));
    let (empty, body) = body.strip_suffix(b"/").map_or((false, body), |body| (true, body));
    let split = body.iter().position(u8::is_ascii_whitespace).unwrap_or(body.len());
    let (name, attributes) = body.split_at(split);
    Some(Tag { name, attributes, closing, empty, start, end: start + length + 2 })
}
