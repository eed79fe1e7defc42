//! Spelling suggestions: the known word nearest to an unknown one.

/// Returns the first candidate that differs from the word in at most one letter, or by a swap of two adjacent letters.
pub(crate) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .find(|candidate| !word.is_empty() && is_near(word.as_bytes(), candidate.as_bytes()))
}

fn is_near(a: &[u8], b: &[u8]) -> bool {
    let common = a.iter().zip(b).take_while(|(a, b)| a == b).count();
    let (a, b) = (&a[common..], &b[common..]);
    match (a, b) {
        ([], []) => true,
        ([p, q, a @ ..], [r, s, b @ ..]) if (p, q) == (s, r) && a == b => true,
        ([_, a @ ..], [_, b @ ..]) if a == b => true,
        ([_, rest @ ..], other) | (other, [_, rest @ ..]) if rest == other => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn one_letter_may_differ() {
        let known = ["node", "vtu", "csv"];
        for (word, expected) in [
            ("vut", Some("vtu")),
            ("vtuu", Some("vtu")),
            ("vt", Some("vtu")),
            ("cvs", Some("csv")),
            ("ndoe", Some("node")),
            ("nodes", Some("node")),
            ("xnode", Some("node")),
            ("zzz", None),
            ("", None),
        ] {
            assert_eq!(nearest(word, known), expected, "{word}");
        }
    }
}
