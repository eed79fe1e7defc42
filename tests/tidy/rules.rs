//! Rules for single files: their length, what they name, what they are free of.

use std::fs;

use fancy_regex::Regex;

use crate::source::{code, files, files_of, is_test, root};
use crate::syntax::definitions;

/// A file has fewer lines than this. Vendored files are exempt.
const MOST_LINES: usize = 540;

/// A function has fewer lines than this.
const MOST_FUNCTION_LINES: usize = 70;

/// The first line that holds one of the words.
fn named(text: &str, words: &[&str]) -> Option<String> {
    let holds = |line: &&str| words.iter().any(|word| line.contains(word));
    text.lines().find(holds).map(|line| line.trim().to_string())
}

/// Files below a folder, tests left out, whose code holds one of the words.
fn offenders(folder: &str, words: &[&str]) -> Vec<(String, String)> {
    let plain = files(folder).into_iter().filter(|(name, _)| !is_test(name));
    plain.filter_map(|(name, text)| named(&code(&text), words).map(|line| (name, line))).collect()
}

#[test]
fn files_are_short() {
    for folder in ["src", "workers", "tests", "bench"] {
        for (name, text) in files(folder).into_iter().chain(files_of(folder, &["js", "mjs", "py"])) {
            let lines = text.lines().count();
            assert!(lines < MOST_LINES, "{name} has {lines} lines: split it");
        }
    }
}

/// The functions of a formatted text with at least `most` lines, from the signature to the closing brace.
fn long_functions(text: &str, most: usize) -> Vec<String> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (start, line) in lines.iter().enumerate() {
        let plain = line.trim_start();
        let Some((before, after)) = plain.split_once("fn ") else { continue };
        let is_head = before.split(' ').all(|word| {
            ["", "pub", "const", "async", "unsafe", "extern"].contains(&word) || word.starts_with("pub(")
        });
        if !is_head || line.ends_with(['}', ';']) {
            continue;
        }
        let indent = &line[..line.len() - plain.len()];
        let is_end = |line: &&str| {
            line.strip_prefix(indent).is_some_and(|l| l == "}" || l.starts_with(") ") && l.ends_with(';'))
        };
        let len = lines[start..].iter().position(is_end).map_or(lines.len() - start, |len| len + 1);
        if len >= most {
            let name = after.split(['(', '<']).next().unwrap_or("");
            found.push(format!("{name}: {len} lines"));
        }
    }
    found
}

#[test]
fn functions_are_short() {
    for folder in ["src", "workers", "tests", "bench"] {
        for (name, text) in files(folder) {
            let long = long_functions(&text, MOST_FUNCTION_LINES);
            assert!(long.is_empty(), "{name} has long functions: {long:?}");
        }
    }
}

#[test]
fn a_planted_long_function_is_found() {
    let text = "trait T {\n    fn none(\n        &self,\n    ) -> u8;\n}\n\npub(crate) async fn f<P>(\n    p: P,\n) {\n    {\n    }\n}\n";
    assert_eq!(long_functions(text, 6), ["f: 6 lines"]);
    assert!(long_functions(text, 7).is_empty());
}

/// The transports are the workers' business; the library gets a machine from `machine` or from its caller.
#[test]
fn the_library_names_no_transport_type() {
    let concrete = ["channel::Channels", "sim::Sim", "Channels::new", "Sim::new"];
    for name in ["Channels", "Sim"] {
        let transports = files("workers/src/hosts/transport");
        let defines = |text: &str| definitions(text).iter().any(|definition| definition.name == name);
        assert!(transports.iter().any(|(_, text)| defines(text)), "no transport has the name {name}");
    }
    let found: Vec<_> =
        offenders("src", &concrete).into_iter().filter(|(name, _)| name != "src/main.rs").collect();
    assert!(found.is_empty(), "these name a transport: {found:#?}");
}

/// What pure code does not use: clocks, threads, files, sockets, standard output, maps whose order is left to chance. A
/// group of imports from `std` could name them without their paths.
const IMPURE: [&str; 8] =
    ["std::time", "std::thread", "std::fs", "std::net", "std::{", "HashMap", "HashSet", "println!"];

/// The ways to print or to end the process.
const EFFECTS: [&str; 6] = ["print!(", "println!(", "eprint!(", "eprintln!(", "dbg!(", "process::exit"];

/// The folders of the crates that neither print nor know the command line.
const LIBRARIES: [&str; 10] = [
    "src/core",
    "src/io",
    "src/lab",
    "src/verify",
    "src/meshing",
    "src/queries",
    "src/doors",
    "src/c",
    "src/python",
    "workers",
];

/// The command line prints and sets the exit code.
#[test]
fn libraries_do_not_print_or_exit() {
    let mut found: Vec<_> = LIBRARIES.iter().flat_map(|folder| offenders(folder, &EFFECTS)).collect();
    // A build script prints its orders to Cargo.
    found.retain(|(name, _)| !name.ends_with("/build.rs"));
    // The programs septet and septet-mpi are in the folders of libraries.
    for file in ["src/lib.rs", "src/mpi/lib.rs", "src/mpi/wire.rs", "src/mpi/parts.rs", "src/mpi/idle.rs"] {
        let text = code(&fs::read_to_string(root().join(file)).unwrap());
        found.extend(named(&text, &EFFECTS).map(|line| (file.to_string(), line)));
    }
    assert!(found.is_empty(), "these print or exit: {found:#?}");
}

/// The words of options on the command line, such as `--json` and `-d 2`.
const OPTIONS: &str = r#"--[a-z]|"[^"]*[ `(]-[dnoxy][ `,)"]"#;

/// These write command lines: the line of a run has the command that repeats it, and a journal the options of its claims.
const COMMAND_LINES: [&str; 2] = ["src/lab/experiment/sweep.rs", "src/lab/claims/journal.rs"];

/// The command line, and every other door, spells options in its own way.
#[test]
fn libraries_name_no_option_of_the_command_line() {
    let option = Regex::new(OPTIONS).unwrap();
    let all = LIBRARIES.iter().flat_map(|folder| files(folder));
    let plain = all.filter(|(name, _)| !is_test(name) && !COMMAND_LINES.contains(&name.as_str()));
    let named =
        |text: &str| code(text).lines().find(|line| option.is_match(line).unwrap()).map(str::to_owned);
    let found: Vec<_> = plain.filter_map(|(name, text)| Some((name, named(&text)?))).collect();
    assert!(found.is_empty(), "these name an option of the command line: {found:#?}");
    for planted in ["    #[error(\"omit --raw\")]", "        more text, or use --raw\"", "f(\"use -d 2\")"] {
        assert!(named(planted).is_some(), "{planted}");
    }
    assert!(named("let opposite = x - -d; // --raw").is_none());
}

#[test]
fn geometry_meshing_and_queries_are_pure() {
    for folder in ["workers/geometry/src", "src/meshing", "src/queries"] {
        let found = offenders(folder, &IMPURE);
        assert!(found.is_empty(), "these are not pure: {found:#?}");
    }
}

/// Ranks read no file and no clock; the transports do what the machine needs.
#[test]
fn ranks_read_no_file_and_no_clock() {
    let mut found = offenders("workers/src", &["std::time", "std::fs", "std::net", "std::{", "println!"]);
    found.retain(|(name, _)| !name.starts_with("workers/src/hosts/transport/"));
    assert!(found.is_empty(), "these read a file or a clock: {found:#?}");
}

/// An oracle that shares code shares bugs.
#[test]
fn the_verifier_shares_no_predicate() {
    let found = offenders("src/verify", &["septet_geometry", "robust::"]);
    assert!(found.is_empty(), "these use the builder's predicates: {found:#?}");
}

#[test]
fn a_planted_word_is_found() {
    let planted = "//! Not std::fs here.\nfn f() {\n    let now = std::time::Instant::now();\n}\n";
    assert_eq!(named(&code(planted), &IMPURE).as_deref(), Some("let now = std::time::Instant::now();"));
    let in_tests = "fn f() {}\n#[cfg(test)]\nmod tests {\n    use std::fs;\n}\n";
    assert_eq!(named(&code(in_tests), &IMPURE), None);
    assert_eq!(
        named(&code("#[cfg(test)]\nmod tests;\nuse std::fs;\n"), &IMPURE).as_deref(),
        Some("use std::fs;")
    );
}

/// The structs of a text with more fields than `most`.
fn large_structs(text: &str, most: usize) -> Vec<String> {
    let mut found = Vec::new();
    for (start, _) in text.match_indices("struct ") {
        let rest = &text[start + "struct ".len()..];
        let Some((head, body)) = rest.split_once('{') else { continue };
        if head.contains([';', '(']) {
            continue;
        }
        let body = body.split_once("\n}").map_or(body, |(body, _)| body);
        let fields = body.lines().filter(|line| {
            let line = line.strip_prefix("    ").unwrap_or("");
            let name = line.split_once(':').map_or("", |(name, _)| name);
            let name = name.rsplit(' ').next().unwrap_or("");
            !line.starts_with(' ') && !name.is_empty() && !name.contains(['/', '#', ')'])
        });
        if fields.count() > most {
            found.push(head.trim().to_string());
        }
    }
    found
}

/// No struct of the machine has more fields than a reader keeps in mind.
#[test]
fn structs_of_the_machine_are_small() {
    for (name, text) in files("workers/src").into_iter().filter(|(name, _)| !is_test(name)) {
        let large = large_structs(&code(&text), 12);
        assert!(large.is_empty(), "{name}: more than 12 fields in {large:?}");
    }
}

#[test]
fn a_planted_large_struct_is_found() {
    let text = "struct Small {\n    a: u8,\n}\n\npub struct Large<P> {\n    pub a: P,\n    pub(crate) b: u8,\n    c: u8,\n}\n";
    assert_eq!(large_structs(text, 2), ["Large<P>"]);
}

/// A template of an issue without front matter in separate lines is not offered.
#[test]
fn templates_of_issues_have_front_matter() {
    let folder = root().join(".github/ISSUE_TEMPLATE");
    let entries: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(!entries.is_empty(), "no template was found");
    for path in entries {
        let text = fs::read_to_string(&path).unwrap();
        let head = text.split_once("\n---\n").map_or("", |(head, _)| head);
        let is_whole = head.starts_with("---\nname: ") && head.contains("\nabout: ");
        assert!(is_whole, "{} must begin with `---`, a line `name: ` and a line `about: `", path.display());
    }
}
