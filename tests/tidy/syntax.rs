//! Signatures, types and `impl` blocks of a formatted text without comments.

/// A function by its signature.
pub struct Function<'a> {
    /// Whether it is async and visible outside its file.
    pub is_phase: bool,
    /// The patterns of its parameters with their types. A receiver has an empty type.
    pub parameters: Vec<(&'a str, &'a str)>,
    /// The type that it returns. Empty if it returns no value.
    pub result: &'a str,
}

/// The functions of a text.
pub fn functions(text: &str) -> Vec<Function<'_>> {
    text.match_indices("fn ").filter_map(|(at, _)| function(text, at)).collect()
}

/// The function whose keyword `fn` is at this position. `None` if the position is within a word or a type.
fn function(text: &str, at: usize) -> Option<Function<'_>> {
    let head = text[..at].rsplit('\n').next().unwrap_or("").trim_start();
    let mut before = head.split(' ');
    let is_word = |word: &str| ["", "pub", "const", "async", "unsafe", "in"].contains(&word);
    let is_visibility = |word: &str| word.starts_with("pub(") || word.ends_with(')');
    if !before.all(|word| is_word(word) || is_visibility(word)) {
        return None;
    }
    let rest = &text[at + "fn ".len()..];
    let rest = &rest[rest.find(|c| !is_part(c))?..];
    let rest = if rest.starts_with('<') { &rest[balanced(rest)..] } else { rest };
    let length = balanced(rest);
    let parameters = split(&rest[1..length - 1], ',').into_iter().map(str::trim).filter(|p| !p.is_empty());
    let result =
        rest[length..].trim_start().strip_prefix("->").map_or("", |after| type_at(after.trim_start()));
    Some(Function {
        is_phase: head.starts_with("pub") && head.contains("async "),
        parameters: parameters.map(typed).collect(),
        result: result.trim_end(),
    })
}

/// A pattern and its type.
fn typed(binding: &str) -> (&str, &str) {
    let parts = split(binding, ':');
    parts.get(1).map_or((binding, ""), |_| (parts[0].trim(), binding[parts[0].len() + 1..].trim()))
}

/// The typed patterns of the `let` statements of a text.
pub fn lets(text: &str) -> Vec<(&str, &str)> {
    let after = text.match_indices("let ").map(|(at, word)| &text[at + word.len()..]);
    let declared = |after| {
        let binding = split(after, '=')[0];
        typed(binding.split(';').next().unwrap_or(""))
    };
    after.map(declared).filter(|(_, of)| !of.is_empty()).collect()
}

/// The change of depth at a character. The head of an arrow closes no bracket.
fn step(c: char, before: char) -> i32 {
    match c {
        '<' | '(' | '[' | '{' => 1,
        '>' if before == '-' || before == '=' => 0,
        '>' | ')' | ']' | '}' => -1,
        _ => 0,
    }
}

/// The length of the bracketed text that a text begins with.
fn balanced(text: &str) -> usize {
    let (mut depth, mut before) = (0, ' ');
    for (at, c) in text.char_indices() {
        depth += step(c, before);
        before = c;
        if depth == 0 {
            return at + 1;
        }
    }
    text.len()
}

/// The parts of a text between separators outside brackets. A text ends at a bracket that closes none of its own. Neither
/// colon of a path separates.
fn split(text: &str, separator: char) -> Vec<&str> {
    let (mut parts, mut start, mut depth, mut before) = (Vec::new(), 0, 0, ' ');
    for (at, c) in text.char_indices() {
        depth += step(c, before);
        if depth < 0 {
            parts.push(&text[start..at]);
            return parts;
        }
        let in_path = c == ':' && (before == ':' || text[at + 1..].starts_with(':'));
        if c == separator && depth == 0 && !in_path {
            parts.push(&text[start..at]);
            start = at + 1;
        }
        before = c;
    }
    parts.push(&text[start..]);
    parts
}

/// The type that a text begins with. The arguments of a call or of a function type are no part of it.
pub fn type_at(text: &str) -> &str {
    let (mut depth, mut before) = (0, ' ');
    for (at, c) in text.char_indices() {
        let is_end = match c {
            '(' => before.is_alphanumeric(),
            ',' | ';' | '=' | '{' | '|' => true,
            _ => step(c, before) < 0,
        };
        if depth == 0 && is_end {
            return &text[..at];
        }
        depth += step(c, before);
        before = c;
    }
    text
}

/// The words of a text.
pub fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c| !is_part(c)).filter(|word| !word.is_empty())
}

/// The types behind `&mut` in a text, wherever they occur: in signatures, closures, fields and variables.
pub fn mutable_references(text: &str) -> Vec<&str> {
    let references = mutable(text).filter(|(before, after)| is_reference(before) && is_type(after));
    references.map(|(_, after)| type_at(after)).collect()
}

/// The types of the variables `mut x: T` of a text.
pub fn mutable_variables(text: &str) -> Vec<&str> {
    let variables = mutable(text).filter(|(before, _)| !is_reference(before));
    let declared = variables.filter_map(|(_, after)| after.trim_start_matches(is_part).strip_prefix(": "));
    declared.map(type_at).collect()
}

/// The texts before and after each word `mut`.
fn mutable(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let all = text.match_indices("mut ").map(|(at, word)| (&text[..at], &text[at + word.len()..]));
    all.filter(|(before, _)| !before.ends_with(is_part))
}

/// Whether the word `mut` after this text belongs to a reference. The reference may have a lifetime.
fn is_reference(before: &str) -> bool {
    let lifetime = before.trim_end().rsplit_once("&'").is_some_and(|(_, name)| name.chars().all(is_part));
    before.ends_with('&') || lifetime
}

/// Whether a text begins with a type instead of a variable.
fn is_type(text: &str) -> bool {
    let path = text.split(|c| !is_part(c) && c != ':').next().unwrap_or("");
    let named = path.split("::").any(|word| word.starts_with(char::is_uppercase));
    named || text.starts_with(['(', '[', '&']) || text.starts_with("dyn ") || text.starts_with("impl ")
}

/// Whether a word may contain a character.
fn is_part(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// A type without the types behind its references.
pub fn by_value(mut text: &str) -> String {
    let mut kept = String::new();
    while let Some((before, after)) = text.split_once('&') {
        kept.push_str(before);
        text = &after[type_at(after).len()..];
    }
    kept + text
}

/// The types that have an `impl` block in a text, without their paths and parameters.
pub fn implemented(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let plain = line.trim_start();
        if plain.starts_with("impl<") || plain.starts_with("impl ") {
            let header = &text[start + line.len() - plain.len() + "impl".len()..];
            let header = if header.starts_with('<') { &header[balanced(header)..] } else { header };
            let header = header.split('{').next().unwrap_or("");
            let header =
                header.split_once(" for ").map_or(header, |(_, of)| of).trim_start_matches([' ', '&']);
            let path = header.split(['<', ' ', '\n']).next().unwrap_or("");
            found.extend(path.rsplit("::").next());
        }
        start += line.len();
    }
    found
}

/// The definition of a type or trait.
#[derive(Debug, PartialEq, Eq)]
pub struct Definition<'a> {
    /// The keyword: struct, enum, trait or type.
    pub kind: &'a str,
    /// The name.
    pub name: &'a str,
    /// Whether it is visible outside its file.
    pub is_visible: bool,
    /// Whether it derives `Copy`.
    pub is_copy: bool,
    /// The text from its name on.
    pub text: &'a str,
}

/// The definitions of a text, without those inside other items.
pub fn definitions(text: &str) -> Vec<Definition<'_>> {
    let (mut found, mut start, mut is_copy) = (Vec::new(), 0, false);
    for line in text.split_inclusive('\n') {
        let item = match line.strip_prefix("pub") {
            Some(rest) if rest.starts_with('(') => rest.split_once(") ").map_or("", |(_, item)| item),
            Some(rest) => rest.trim_start(),
            None => line,
        };
        let mut all = item.split(|c| !is_part(c));
        let kind = all.next().filter(|word| ["struct", "enum", "trait", "type"].contains(word));
        if let (Some(kind), Some(name)) = (kind, all.next()) {
            let at = start + line.len() - item.len() + kind.len() + 1;
            let is_visible = line.starts_with("pub");
            found.push(Definition { kind, name, is_visible, is_copy, text: &text[at..] });
        }
        is_copy = line.starts_with('#') && (is_copy || words(line).any(|word| word == "Copy"));
        start += line.len();
    }
    found
}

/// The fields of a struct that have a visibility, from its definition.
pub fn visible_fields(definition: &str) -> Vec<&str> {
    let end =
        definition.find("\n}").into_iter().chain(definition.find(";\n")).min().unwrap_or(definition.len());
    let body = definition[..end].split_once(['{', '(']).map_or("", |(_, body)| body);
    body.lines().map(str::trim).filter(|line| words(line).any(|word| word == "pub")).collect()
}

#[test]
fn signatures_are_read() {
    let text = "pub(crate) async fn f<'a, F: Fn(&P) -> u8>(\n    &mut self,\n    (a, b): (A<P>, [u8; 2]),\n    c: m::C,\n) -> Result<R, E>\nwhere\n    P: Point,\n{\n    g(|fn_x| 0)\n}\nfn g(f: fn(u8) -> B);\n";
    let found = functions(text);
    assert!(found[0].is_phase && !found[1].is_phase && found.len() == 2);
    assert_eq!(found[0].parameters, [("&mut self", ""), ("(a, b)", "(A<P>, [u8; 2])"), ("c", "m::C")]);
    assert!(found[0].result.starts_with("Result<R, E>") && found[1].result.is_empty());
    assert_eq!(found[1].parameters, [("f", "fn(u8) -> B")]);
}

#[test]
fn definitions_are_read() {
    let text = "#[derive(Clone, Copy)]\n#[repr(C)]\npub(in crate::a) struct A(pub u8, pub(super) u8);\n\npub enum B {}\n\npub struct F(pub(crate) u8);\n\ntype C<P> = Vec<P>;\n\npub(super) struct D<P> {\n    pub(crate) d: P,\n    e: P,\n}\n\nimpl D {\n    type Inner = u8;\n}\n";
    let found: Vec<_> = definitions(text).iter().map(|d| (d.kind, d.name, d.is_visible, d.is_copy)).collect();
    let expected = [
        ("struct", "A", true, true),
        ("enum", "B", true, false),
        ("struct", "F", true, false),
        ("type", "C", false, false),
        ("struct", "D", true, false),
    ];
    assert_eq!(found, expected);
    let fields: Vec<_> = definitions(text).iter().map(|d| visible_fields(d.text)).collect();
    assert_eq!((&fields[0], &fields[4]), (&vec!["pub u8, pub(super) u8)"], &vec!["pub(crate) d: P,"]));
}
