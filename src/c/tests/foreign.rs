//! The header, the exported names, and programs in other languages that are built with `pkg-config`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs a program, which must succeed, and returns what it prints.
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}; install the program"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {}\n{text}{errors}", output.status);
    assert!(errors.is_empty(), "{command:?}: {errors}");
    text
}

/// The folder of this crate.
fn source() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folder with the libraries that were built for this test.
fn built() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

/// A folder like `dist/c`, with the libraries of this build.
fn dist() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    run(Command::new("bash").arg(source().join("build")).arg(built()).arg(folder.path()));
    folder
}

/// The words that `pkg-config` prints.
fn flags(dist: &Path, arguments: &[&str]) -> Vec<String> {
    let mut command = Command::new("pkg-config");
    command.args(arguments).arg("septet").env("PKG_CONFIG_PATH", dist.join("lib/pkgconfig"));
    run(&mut command).split_whitespace().map(str::to_owned).collect()
}

#[test]
fn the_header_is_strict_c_and_cpp() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("header.c");
    fs::write(&file, "#include <septet.h>\n#include <septet.h>\nint main(void) { return SEPTET_OK; }\n")
        .unwrap();
    for (compiler, language, standard) in [("gcc", "c", "c99"), ("g++", "c++", "c++17")] {
        let mut command = Command::new(compiler);
        command.args([
            "-x",
            language,
            &format!("-std={standard}"),
            "-Wall",
            "-Wextra",
            "-pedantic",
            "-Werror",
        ]);
        run(command.args(["-fsyntax-only", "-I"]).arg(source().join("include")).arg(&file));
    }
}

#[test]
fn the_header_declares_what_the_library_exports() {
    let header = fs::read_to_string(source().join("include/septet.h")).unwrap();
    // The text after a comment's end, up to the next comment.
    let code: String = header.split("*/").filter_map(|part| part.split("/*").next()).collect();
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let names = code.match_indices("septet_").filter_map(|(at, _)| {
        let name = code[at..].split(|c| !is_part(c)).next()?;
        code[at + name.len()..].starts_with('(').then_some(name)
    });
    let declared: BTreeSet<&str> = names.collect();
    let symbols = run(Command::new("nm").args(["-D", "--defined-only"]).arg(built().join("libseptet_c.so")));
    let exported: BTreeSet<&str> = symbols.lines().filter_map(|line| line.split(' ').next_back()).collect();
    assert!(declared.len() > 20, "{declared:?}");
    assert_eq!(declared, exported);
    let dynamic = run(Command::new("readelf").arg("-d").arg(built().join("libseptet_c.so")));
    assert!(dynamic.contains("soname: [libseptet.so.1]"), "{dynamic}");
}

const PRINTED_BY_C: &str = "\
ABI 1, dimension 3, rank 3
125 points, 192 facets on the hull
first cell: 0 1 ";

#[test]
fn a_c_program_uses_the_library() {
    let dist = dist();
    let program = dist.path().join("program");
    for (linked, arguments) in
        [("shared", &["--cflags", "--libs"][..]), ("static", &["--cflags", "--libs", "--static"])]
    {
        let mut command = Command::new("gcc");
        command.args(["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-o"]).arg(&program);
        command.arg(source().join("examples/triangulate.c"));
        let mut flags = flags(dist.path(), arguments);
        if linked == "static" {
            let archive = dist.path().join("lib/libseptet.a").display().to_string();
            flags.iter_mut().filter(|flag| *flag == "-lseptet").for_each(|flag| flag.clone_from(&archive));
        }
        run(command.args(flags));
        let printed = run(Command::new(&program).env("LD_LIBRARY_PATH", dist.path().join("lib")));
        assert!(printed.starts_with(PRINTED_BY_C), "{linked}: {printed}");
        let rest: Vec<&str> = printed.lines().skip(3).collect();
        // A query in the middle has the value 1.5 + 10 * 2.25 + 100 * 3; one outside has the value that the caller chose.
        assert!(
            rest[0].starts_with("inside, nearest ") && rest[0].ends_with(", value 324"),
            "{linked}: {printed}"
        );
        assert_eq!(
            rest[1..],
            ["inside, nearest 124, value 444", "outside, nearest 4, value -1", "status 3 at point 1"]
        );
    }
}

#[test]
fn a_fortran_program_uses_the_library() {
    let dist = dist();
    let program = dist.path().join("program");
    let mut command = Command::new("gfortran");
    command
        .args(["-std=f2018", "-Wall", "-Wextra", "-Werror", "-J"])
        .arg(dist.path())
        .arg("-o")
        .arg(&program);
    run(command.arg(source().join("examples/triangulate.f90")).args(flags(dist.path(), &["--libs"])));
    let printed = run(Command::new(&program).env("LD_LIBRARY_PATH", dist.path().join("lib")));
    // Each corner has an eighth of the square, and the middle has the rest.
    assert_eq!(printed, "  0  1  4\n  0  4  3\n  1  2  4\n  2  3  4\n  0.50  0.50  0.50  0.50  2.00\n");
}
