//! The prose of documents, comments and strings: the share of sentences with constructions that native technical writers
//! avoid, and of sentences that are too long.
//!
//! A marked sentence is a place to look at, not an error: a document or crate may have a few of them. The strings of a crate
//! (errors, help, summaries) are counted apart from its comments.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use fancy_regex::Regex;

use crate::source::{files, files_of, is_test, root};

/// Marked sentences may be this share of a document or crate; two are free.
const MOST_MARKED: f64 = 0.02;

/// So may be sentences of more than 30 words.
const MOST_LONG: f64 = 0.05;

/// The documents, and folders of documents.
const DOCUMENTS: [&str; 7] =
    ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "bench", ".github", "src", "workers"];

/// The crates, by the folder of their sources.
const CRATES: [&str; 15] = [
    "src/core",
    "src/io",
    "src/verify",
    "src/meshing",
    "src/queries",
    "src/lab",
    "src/cli",
    "src/mpi",
    "src/doors",
    "src/c",
    "src/python",
    "workers/src",
    "workers/geometry/src",
    "workers/protocol/src",
    "bench/src",
];

/// The files of the crate at the root.
const ROOT_FILES: [&str; 2] = ["src/lib.rs", "src/main.rs"];

/// A string has at least this many words in small letters if it is prose.
const LEAST_WORDS: usize = 4;

/// A person may be followed by "who"; a machine may not.
const PERSON: &str = r"(?<!user )(?<!users )(?<!people )(?<!someone )(?<!anyone )(?<!those )(?<!everyone )(?<!reader )(?<!readers )(?<!author )(?<!callers )(?<!caller )(?<!developers )(?<!contributors )";

/// Constructions, by name. The first three look at the beginning of a sentence and heed case.
fn patterns() -> Vec<(&'static str, Regex)> {
    let plain = [
        (
            "noun clause first",
            r"^What (?!to\b|(this|that) means\b|if\b)(?=.*[a-z])[a-z]|^(Who |Whoever |Whatever |Which |How (?!to\b))[a-z' -]+$",
        ),
        ("condition with where", r"^Where (there is|there are|it is|they are|it has|they have|one is)\b"),
        ("boolean as a question", r"^(Is|Are|Has|Have|Does|Do|Did|Can|Was|Were|Must|Should|Could) [^?]*\?$"),
    ];
    let person = format!(
        r"(?i)\b(whoever|nobody|somebody|everybody|who else)\b|{PERSON}\bwho (must|has|have|is|are|may|can|sent|sends|starts|holds|asked|asks)\b"
    );
    let folded = [
        (
            "what is",
            r"(?<![.?!] )\bwhat (is|are|was|were|no|that|comes|came|goes|stands|has|had|can|cannot|must|lies)\b|\b(of|than|beyond|from|by) what\b",
        ),
        (
            "told",
            r"\b(told|tells? (that|whether|what|who|which|apart|of))\b|\b(those|that) (of what|who|which|what)\b",
        ),
        (
            "negated noun",
            r"(?<!there )\b(is|are|was|were) no (?!longer|more|less|different|better|worse|fewer|greater|larger|smaller|such|need|way)[a-z]+\b|\b(has|have|had) not[.,;:)]|\b(is|has) none\b",
        ),
        (
            "archaic",
            r"\bstands?\b(?! (for|in|out)\b)|\bstood\b|\bat hand\b|\bas ever\b|\banew\b|\bput right\b|\bmend(s|ed|ing)?\b|\bin the place of\b|\b(is|are) due\b(?! to)|\bheeded\b|\bwished?\b|\blacking\b|\btorn\b|\blet in\b",
        ),
        ("so many", r"\bso many\b(?! (more|as|that)\b)"),
        ("but for", r"(?<=[a-z] )but for (?!now\b|each\b|all\b|the moment)|\b(be it|save for|for want of)\b"),
    ];
    let case = plain.map(|(name, pattern)| (name, Regex::new(pattern).unwrap()));
    let mut all: Vec<_> = case.into_iter().collect();
    all.extend(folded.map(|(name, pattern)| (name, Regex::new(&format!("(?i){pattern}")).unwrap())));
    all.push(("a person for a machine", Regex::new(&person).unwrap()));
    all
}

/// Splits blocks of text into sentences.
struct Splitter {
    /// Code, links, spaces and the dots of abbreviations, with their replacements.
    rules: [(Regex, &'static str); 5],
    /// The end of a sentence.
    end: Regex,
}

impl Splitter {
    fn new() -> Self {
        let rules = [
            (r"``.*?``|`[^`]*`", "X"),
            (r"\[([^\]]*)\](\([^)]*\)|\[[^\]]*\])?", "$1"),
            (r"https?://\S+", "X"),
            (r"\s+", " "),
            (r"\b(e\.g|i\.e|cf|vs|etc|al|Fig|Thm|Def|Sec)\.", "$1"),
        ];
        Splitter {
            rules: rules.map(|(pattern, by)| (Regex::new(pattern).unwrap(), by)),
            end: Regex::new(r#"[.?!:][*_"')]*\s+(?=[A-Z\[(*_])"#).unwrap(),
        }
    }

    /// The sentences of a block, those of fewer than four words left out.
    fn sentences(&self, block: &str) -> Vec<String> {
        let replace =
            |text: String, (pattern, by): &(Regex, &str)| pattern.replace_all(&text, *by).into_owned();
        let text = self.rules.iter().fold(block.to_string(), replace);
        let ends = self.end.find_iter(&text).map(|end| end.unwrap().end());
        let mut starts: Vec<usize> = std::iter::once(0).chain(ends).collect();
        starts.push(text.len());
        let mut all: Vec<_> =
            starts.windows(2).map(|pair| text[pair[0]..pair[1]].trim().to_string()).collect();
        all.retain(|sentence| words(sentence) >= 4);
        all
    }
}

/// Words of at least two letters.
fn words(sentence: &str) -> usize {
    let letters = |c: char| c.is_ascii_alphabetic() || c == '\'' || c == '-';
    sentence
        .split(|c| !letters(c))
        .filter(|word| word.chars().filter(char::is_ascii_alphabetic).count() > 1)
        .count()
}

/// Paragraphs and items of lists of a Markdown text, without fences, tables, headings and quotes.
fn paragraphs<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<String> {
    let (mut blocks, mut open, mut fenced) = (Vec::new(), String::new(), false);
    for line in lines {
        let text = line.trim_start();
        let fence = text.starts_with("```") || text.starts_with("~~~");
        fenced ^= fence;
        let skipped = fenced || fence || text.is_empty() || text.starts_with(['#', '|', '>', '<']);
        let item = text.starts_with("- ") || text.starts_with("* ") || numbered(text);
        if skipped || item {
            blocks.push(std::mem::take(&mut open));
        }
        if !skipped {
            open.push_str(text.trim_start_matches(['-', '*', ' ']));
            open.push(' ');
        }
    }
    blocks.push(open);
    blocks.retain(|block| !block.trim().is_empty());
    blocks
}

fn numbered(text: &str) -> bool {
    text.split_once(". ")
        .is_some_and(|(head, _)| !head.is_empty() && head.bytes().all(|b| b.is_ascii_digit()))
}

/// The comments of a Rust file, up to its tests.
fn comments(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or("");
    let lines = code.lines().map(|line| {
        let line = line.trim_start();
        let comment = ["//!", "///", "//"].iter().find_map(|mark| line.strip_prefix(mark));
        comment.unwrap_or("")
    });
    paragraphs(lines)
}

/// Finds the prose in the string literals of Rust code.
struct Strings {
    /// Comments, characters and string literals.
    literal: Regex,
    /// Signs of code.
    foreign: Regex,
    /// Escapes, lines of roff, and places of values, with their replacements.
    rules: [(Regex, &'static str); 6],
    /// The end of a part of a string.
    end: Regex,
    /// A word in small letters.
    word: Regex,
}

impl Strings {
    fn new() -> Self {
        let literal =
            r##"(?s)//[^\n]*|/\*.*?\*/|b?'(?:\\.[^']*|[^'\\])'|b?r#".*?"#|b?r"[^"]*"|b?"(?:\\.|[^"\\])*""##;
        let rules = [
            (r"\\\n\s*", ""),
            (r"\\n", "\n"),
            (r#"\\""#, "\""),
            (r"(?m)^\.[A-Za-z]+\b.*$", "\n"),
            (r"\\flag\{([^}]*)\}", "X"),
            (r"\{[^{}]*\}", "X"),
        ];
        let regex = |pattern: &str| Regex::new(pattern).unwrap();
        Strings {
            literal: regex(literal),
            foreign: regex(r"</|/>|[;{}]\s*\n|=>|::|^\s*<"),
            rules: rules.map(|(pattern, by)| (regex(pattern), by)),
            end: regex(r"\n\s*\n|\n(?=\s+\S)"),
            word: regex(r"\b[a-z][a-z'-]+\b"),
        }
    }

    /// The prose in the strings of a Rust file, up to its tests.
    fn of(&self, text: &str) -> Vec<String> {
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or("");
        let mut found = Vec::new();
        for literal in self.literal.find_iter(code).map(|literal| literal.unwrap().as_str()) {
            if !literal.starts_with(['"', 'r']) {
                continue;
            }
            let inner = literal.trim_start_matches('r').trim_matches('#');
            let inner = inner[1..inner.len() - 1].to_string();
            // Code is recognized after the escapes have been replaced.
            let replace =
                |text: String, (rule, by): &(Regex, &str)| rule.replace_all(&text, *by).into_owned();
            let plain = self.rules[..3].iter().fold(inner, replace);
            if self.foreign.is_match(&plain).unwrap() {
                continue;
            }
            let plain = self.rules[3..].iter().fold(plain, replace);
            let parts = self.end.split(&plain).map(Result::unwrap);
            let prose = parts.filter(|part| self.word.find_iter(part).count() >= LEAST_WORDS);
            found.extend(prose.map(str::to_string));
        }
        found
    }
}

/// The texts of an HTML file between its tags.
fn html(text: &str) -> Vec<String> {
    let texts = text.split('<').filter_map(|piece| piece.split_once('>'));
    texts.map(|(_, text)| text.trim().to_string()).filter(|text| !text.is_empty()).collect()
}

/// Splits texts into sentences and checks them.
struct Reader {
    splitter: Splitter,
    strings: Strings,
    patterns: Vec<(&'static str, Regex)>,
}

impl Reader {
    fn new() -> Self {
        Reader { splitter: Splitter::new(), strings: Strings::new(), patterns: patterns() }
    }
}

/// The counts of a document or crate.
#[derive(Debug, Default)]
struct Tally {
    sentences: usize,
    marked: Vec<String>,
    long: Vec<String>,
}

impl Tally {
    fn add(&mut self, place: &str, blocks: &[String], reader: &Reader) {
        for sentence in blocks.iter().flat_map(|block| reader.splitter.sentences(block)) {
            self.sentences += 1;
            let hit = reader.patterns.iter().find(|(_, pattern)| {
                let text = sentence.trim_end_matches(['.', ':']);
                pattern.is_match(text).unwrap()
            });
            if let Some((name, _)) = hit {
                self.marked.push(format!("{place}: [{name}] {sentence}"));
            }
            if words(&sentence) > 30 {
                self.long.push(format!("{place}: {sentence}"));
            }
        }
    }

    /// Whether it keeps to both bounds.
    fn keeps(&self) -> bool {
        let most = |share: f64| (share * self.sentences as f64).max(2.0);
        self.marked.len() as f64 <= most(MOST_MARKED) && self.long.len() as f64 <= most(MOST_LONG)
    }
}

fn markdown(place: &Path, found: &mut Vec<(String, String)>) {
    if place.is_dir() {
        let mut entries: Vec<_> = fs::read_dir(place).unwrap().map(|entry| entry.unwrap().path()).collect();
        entries.sort();
        for entry in &entries {
            markdown(entry, found);
        }
    } else if place.extension().is_some_and(|ending| ending == "md") {
        let name = place.strip_prefix(root()).unwrap().to_string_lossy().into_owned();
        found.push((name, fs::read_to_string(place).unwrap()));
    }
}

#[test]
fn prose_is_plain() {
    let reader = Reader::new();
    let mut tallies: BTreeMap<String, Tally> = BTreeMap::new();
    for document in DOCUMENTS {
        let mut texts = Vec::new();
        markdown(&root().join(document), &mut texts);
        assert!(!texts.is_empty(), "no document is in {document}");
        for (name, text) in texts {
            let tally = tallies.entry(name.clone()).or_default();
            tally.add(&name, &paragraphs(text.lines()), &reader);
        }
    }
    for (name, text) in files_of("src/cli/page", &["html"]) {
        tallies.entry(name.clone()).or_default().add(&name, &html(&text), &reader);
    }
    let read = |name: &str| (name.to_string(), fs::read_to_string(root().join(name)).unwrap());
    let crates = CRATES.map(|folder| (folder, files(folder)));
    let crates = crates.into_iter().chain([("src", ROOT_FILES.map(read).to_vec())]);
    let mut in_strings = 0;
    for (folder, files) in crates {
        let (mut of_comments, mut of_strings) = (Tally::default(), Tally::default());
        for (name, text) in files.into_iter().filter(|(name, _)| !is_test(name)) {
            of_comments.add(&name, &comments(&text), &reader);
            of_strings.add(&name, &reader.strings.of(&text), &reader);
        }
        in_strings += of_strings.sentences;
        tallies.insert(folder.to_string(), of_comments);
        tallies.insert(format!("{folder} (strings)"), of_strings);
    }
    let all: usize = tallies.values().map(|tally| tally.sentences).sum();
    assert!(all > 6_500, "only {all} sentences are left");
    assert!(in_strings > 800, "only {in_strings} sentences are left in strings");
    let poor: Vec<_> = tallies.into_iter().filter(|(_, tally)| !tally.keeps()).collect();
    let rows: Vec<String> = poor
        .iter()
        .map(|(name, tally)| {
            let (marked, long) = (tally.marked.len(), tally.long.len());
            let examples: Vec<_> = tally.marked.iter().chain(&tally.long).take(20).cloned().collect();
            format!(
                "{name}: {marked} marked and {long} long of {}\n  {}",
                tally.sentences,
                examples.join("\n  ")
            )
        })
        .collect();
    assert!(rows.is_empty(), "rewrite sentences of these:\n{}", rows.join("\n"));
}

#[test]
fn planted_strings_are_found() {
    let strings = Strings::new();
    let text = r##"
// "A comment is not a string."
fn f() -> String {
    let key = ("short", 'x', "one_word_key");
    let code = "fn main() {\n    call(a_long_argument); }\nand more words";
    let raw = r#"the input has "two" columns"#;
    format!("{path}: cannot allocate {bytes} bytes, so \
        split the input") + "usage of the program\n\nwhat is sent is not told"
}
"##;
    let found = strings.of(text);
    let expected = [
        "the input has \"two\" columns",
        "X: cannot allocate X bytes, so split the input",
        "usage of the program",
        "what is sent is not told",
    ];
    assert_eq!(found, expected);
    assert_eq!(html("<p class=\"a\">Drag to turn.</p>\n<b>Reset</b>"), ["Drag to turn.", "Reset"]);
}

#[test]
fn planted_sentences_are_marked() {
    let reader = Reader::new();
    let marked = |text: &str| {
        let mut tally = Tally::default();
        tally.add("planted", &paragraphs(text.lines()), &reader);
        (tally.sentences, tally.marked.len(), tally.long.len())
    };
    assert_eq!(marked("What is sent in a round arrives in the next one."), (1, 1, 0));
    assert_eq!(marked("Is there a message for this rank?"), (1, 1, 0));
    assert_eq!(marked("A rank is told of it. Stars are made anew then."), (2, 2, 0));
    assert_eq!(marked("A worker sends its points to the leader. The leader draws a separator."), (2, 0, 0));
    assert_eq!(marked("```\nWhat is code stands here.\n```\n| what is in a table | stands |"), (0, 0, 0));
    let long = vec!["word"; 31].join(" ");
    assert_eq!(marked(&long), (1, 0, 1));
}
