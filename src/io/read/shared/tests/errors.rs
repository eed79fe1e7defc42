//! Tests of errors, which are the same on all processes.

use super::super::super::ReadOptions;
use super::super::{Call, LIMITS, Limits};
use super::{Ended, Folder, MANY, Processes, data, even, npy, plain, skipping, table, thread_wire, together};
use std::thread;

/// Returns the exit code, and the message with the remedy, on which all processes agree.
fn refused(folder: &Folder, names: &[&str], options: &ReadOptions, limits: Limits) -> (u8, String) {
    let files = folder.paths(names);
    let mut found = None;
    for processes in MANY {
        for part in together(&files, options, processes, limits, even) {
            let Err(Ended::Refused(refused)) = part else { panic!("{part:?}") };
            let now = (refused.code, [refused.message, refused.remedy].join("\n"));
            assert_eq!(*found.get_or_insert_with(|| now.clone()), now);
        }
    }
    found.unwrap()
}

#[test]
fn a_bad_number_is_named_by_file_place_and_row() {
    let folder = Folder::of(&[("a.xyz", &table(10, " ", "\n")), ("b.xyz", "# c\n1 2 3\n\n4 nan 6\n7 8 x\n")]);
    let mut numbers = data("f8", 30);
    numbers[4 * 24 + 8..4 * 24 + 16].copy_from_slice(&f64::INFINITY.to_le_bytes());
    folder.write("c.npy", npy("f8", 10, 3, false, &numbers));
    let (code, message) = refused(&folder, &["a.xyz", "b.xyz", "c.npy"], &plain(), LIMITS);
    assert_eq!(code, 3);
    for part in ["row 11 of the list, row 1 of its file", "b.xyz, line 4", "NaN"] {
        assert!(message.contains(part), "{message}");
    }
    let (_, message) = refused(&folder, &["a.xyz", "c.npy", "b.xyz"], &plain(), LIMITS);
    for part in ["row 14 of the list, row 4 of its file", "c.npy, byte ", "inf"] {
        assert!(message.contains(part), "{message}");
    }
    for names in [&["b.xyz"][..], &["c.npy"], &["c.npy", "b.xyz"], &["a.xyz", "b.xyz", "c.npy"]] {
        folder.check(names, &plain());
        folder.check(names, &skipping());
    }
}

/// Files that are refused, or read, alike by one process and by several.
const SINGLE: [&str; 22] = [
    "short.xyz",
    "wide.xyz",
    "commas.csv",
    "extra.csv",
    "hole.csv",
    "word.xyz",
    "missing.csv",
    "many.xyz",
    "few.xyz",
    "four.csv",
    "cells.txt",
    "header.csv",
    "names.csv",
    "domain.txt",
    "wide16.txt",
    "cut.npy",
    "head.npy",
    "four.npy",
    "no.xyz.gz",
    "a.what",
    "absent.npy",
    ".",
];

/// Returns the folder of the files.
fn faulty() -> Folder {
    let good = table(20, " ", "\n");
    let whole = npy("f8", 10, 3, false, &data("f8", 30));
    let folder = Folder::of(&[
        ("good.xyz", &good),
        ("short.xyz", &format!("{good}1 2\n{good}")),
        ("wide.xyz", &format!("{good}1 2 3 4\n1,5, 2,5, 3,5\n")),
        ("commas.csv", "1,2,3\n1,5, 2,5, 3,5\n1,2,3,4\n"),
        ("extra.csv", "1,2,3\n1,2,3,4\n1,5, 2,5, 3,5\n"),
        ("hole.csv", "x,y,z\n1,2,3\n1,2,3,,4\n1,2,3\n"),
        ("word.xyz", &format!("{good}one two three\n{good}")),
        ("missing.csv", "x,y,z\n1,2,3\n1,2\n"),
        ("many.xyz", "2\n1 2 3\n4 5 6\n7 8 9\n"),
        ("few.xyz", "# c\n5\n1 2 3\n4 5 6\n\n"),
        ("four.csv", "1,2,3,4\n5,6,7,8\n"),
        ("cells.txt", "2 4\n1 1 2 3 4\n2 2 3 4 5\n"),
        ("plane.xyz", "1 2\n3 4\n"),
        ("header.csv", "x,y,z\n"),
        ("names.csv", "a,b,c\n"),
        ("domain.txt", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n3 0\n1 1 2\n2 2 3\n3 3 1\n0\n"),
        ("wide16.txt", "\u{feff}"),
    ]);
    folder.write("wide16.txt", b"\xff\xfe1\0 \0");
    folder.write("cut.npy", &whole[..whole.len() - 1]);
    folder.write("head.npy", &whole[..40]);
    folder.write("four.npy", npy("f8", 2, 4, false, &data("f8", 8)));
    folder.write("float.npy", npy("f4", 2, 3, false, &data("f4", 6)));
    folder.write("whole.npy", &whole);
    folder.write("no.xyz.gz", "1 2 3\n");
    folder.write("a.what", "no text");
    folder
}

#[test]
fn errors_are_those_of_one_process() {
    let folder = faulty();
    for name in SINGLE {
        folder.check(&[name], &plain());
        folder.check(&[name], &skipping());
        folder.check(&["good.xyz", name], &plain());
    }
    folder.check(&["good.xyz", "plane.xyz", "short.xyz"], &plain());
    folder.check(&["whole.npy", "good.xyz", "float.npy"], &plain());
    for dimension in [2, 3, 4] {
        folder.check(&["plane.xyz"], &ReadOptions { dimension: Some(dimension), ..plain() });
        folder.check(&["good.xyz", "plane.xyz"], &ReadOptions { dimension: Some(dimension), ..plain() });
    }
    let columns = Some(vec!["x".to_string(), "w".to_string()]);
    for name in ["missing.csv", "whole.npy"] {
        folder.check(&[name], &ReadOptions { columns: columns.clone(), ..plain() });
    }
}

#[test]
fn large_files_are_refused() {
    let folder = Folder::of(&[("a.xyz", "1 2 3\n"), ("b.node", "1 3 0 0\n1 0 0 0\n")]);
    let (code, message) = refused(&folder, &["a.xyz", "b.node"], &plain(), Limits { whole: 15, ..LIMITS });
    assert!(code == 5 && message.contains("b.node") && message.contains(".npy"), "{message}");
    let limits = Limits { whole: 16, ..LIMITS };
    assert!(together(&folder.paths(&["b.node"]), &plain(), 2, limits, even).iter().all(Result::is_ok));
}

/// Process 0 has the columns of all rows, whatever their order in the files is.
#[test]
fn columns_stay_on_the_first_process() {
    let folder = Folder::of(&[
        ("a.csv", "x,y,z,m,n\n1,2,3,4,5\n1,nan,3,0,0\n"),
        ("b.csv", "x,y,z,n,m\n6,7,8,9,10\n"),
        ("c.csv", "x,y,z,k\n1,2,3,4\n"),
    ]);
    let options = ReadOptions { keep_columns: true, ..skipping() };
    let parts = together(&folder.paths(&["a.csv", "b.csv"]), &options, 3, LIMITS, even);
    let columns: Vec<_> = parts.into_iter().map(|part| part.unwrap().columns).collect();
    let found: Vec<_> = columns[0].iter().map(|of| (of.name.as_str(), &of.values[..])).collect();
    assert_eq!(found, [("m", &[4.0, 10.0][..]), ("n", &[5.0, 9.0][..])]);
    assert!(columns[1].is_empty() && columns[2].is_empty());
    let (code, message) = refused(&folder, &["a.csv", "c.csv"], &options, LIMITS);
    assert!(code == 3 && message.contains("c.csv: the kept columns are k"), "{message}");
}

/// Returns the message if each process has its own files.
fn with_own_files(files: &[Vec<std::path::PathBuf>]) -> String {
    let options = plain();
    let read = |(files, mut wire): (&Vec<std::path::PathBuf>, thread_wire::Threads)| {
        let mut all = Processes::over(&mut wire);
        let (process, processes) = (all.process(), all.processes());
        let call = Call { files, options: &options, limits: LIMITS, stop: &|| false };
        call.read(&mut all, &|rows| even(rows, process, processes)).unwrap_err().to_string()
    };
    let messages: Vec<String> = thread::scope(|scope| {
        let wires = thread_wire::connect(files.len() as u32);
        let each = |of| scope.spawn(move || read(of));
        let threads: Vec<_> = files.iter().zip(wires).map(each).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(messages.iter().all(|message| *message == messages[0]), "{messages:?}");
    messages[0].clone()
}

#[test]
fn processes_must_see_the_same_files() {
    let folder = Folder::of(&[
        ("a.xyz", "1 2 3\n"),
        ("b.xyz", "1 2 3\n4 5 6\n"),
        ("x.csv", "x,y\n1,2\n"),
        ("y.csv", "y,x\n1,2\n"),
    ]);
    folder.write("a.npy", npy("f4", 6, 2, false, &data("f4", 12)));
    folder.write("b.npy", npy("f4", 4, 3, false, &data("f4", 12)));
    let other = |names: [&str; 3]| with_own_files(&names.map(|name| folder.paths(&["a.xyz", name])));
    for (names, parts) in [
        (["a.xyz", "a.xyz", "b.xyz"], ["process 2 sees 12 bytes", "process 0 sees 6 bytes"]),
        (["x.csv", "y.csv", "x.csv"], ["process 1 sees a header", "process 0 sees a header"]),
        (["a.npy", "b.npy", "b.npy"], ["process 1 sees a header", "process 0 sees a header"]),
    ] {
        let message = other(names);
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
    let message = other(["a.xyz", "none.xyz", "a.xyz"]);
    assert!(message.contains("none.xyz: no such file"), "{message}");
    let message = with_own_files(&[folder.paths(&["a.xyz"]), folder.paths(&["a.xyz", "b.xyz"])]);
    assert!(message.contains("process 1 has 2 files"), "{message}");
}

#[test]
fn blocks_must_divide_the_rows() {
    let folder = Folder::of(&[("a.xyz", &table(9, " ", "\n"))]);
    for block in [|_, process, _| u64::from(process)..9, |rows, _, _| 0..rows - 1] {
        for part in together(&folder.paths(&["a.xyz"]), &plain(), 2, LIMITS, block) {
            assert!(matches!(&part, Err(Ended::Refused(refused)) if refused.code == 1), "{part:?}");
        }
    }
}
