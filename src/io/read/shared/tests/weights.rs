//! Weights, of which each process has those of its rows.

use super::super::super::{ReadOptions, WeightOption, WeightSource};
use super::{Folder, LIMITS, data, npy, plain, skipping};

fn of(source: WeightSource, rest: &ReadOptions) -> ReadOptions {
    ReadOptions { weights: Some(WeightOption { source, are_radii: false }), ..rest.clone() }
}

/// Options with weights in a column.
fn column(name: &str, rest: &ReadOptions) -> ReadOptions {
    of(WeightSource::Column(name.to_owned()), rest)
}

/// Options with weights in a file of the folder.
fn file(folder: &Folder, name: &str, rest: &ReadOptions) -> ReadOptions {
    of(WeightSource::File(folder.0.path().join(name)), rest)
}

/// A table of points in the plane with weights. Every seventh row has no weight if `is_damaged`.
fn table(rows: usize, is_damaged: bool) -> String {
    let row = |i: usize| {
        let weight = if is_damaged && i % 7 == 3 { f64::NAN } else { i as f64 / 3.0 - 2.0 };
        format!("{} {} {weight}", i * 37 % 23, i * i % 31)
    };
    (0..rows).map(row).collect::<Vec<_>>().join("\n")
}

/// A text of weights.
fn numbers(rows: usize, is_damaged: bool) -> String {
    let row = |i: usize| if is_damaged && i == 4 { "x".to_owned() } else { format!("{}.5", i * 13 % 11) };
    (0..rows).map(row).collect::<Vec<_>>().join("\n")
}

#[test]
fn columns_are_read_with_the_rows() {
    let folder = Folder::of(&[
        ("a.xyz", &table(20, false)),
        ("b.xyz", &table(20, true)),
        ("c.csv", "x,y,w\n1,2,3\n4,5,6\n"),
    ]);
    folder.write("d.npy", npy("f8", 11, 3, false, &data("f8", 33)));
    folder.write("e.npy", npy("f4", 5, 4, true, &data("f4", 20)));
    for name in ["a.xyz", "b.xyz", "c.csv", "d.npy"] {
        folder.check(&[name], &column("3", &plain()));
        folder.check(&[name], &column("3", &skipping()));
        folder.check(&["a.xyz", name, "a.xyz"], &column("3", &skipping()));
    }
    folder.check(&["e.npy"], &column("4", &plain()));
    folder.check(&["c.csv"], &column("w", &ReadOptions { keep_columns: true, ..plain() }));
    folder.check(&["c.csv"], &column("v", &plain()));
    folder.check(&["a.xyz"], &column("1", &ReadOptions { terrain: true, ..plain() }));
    folder.check(&["d.npy"], &column("4", &plain()));
}

#[test]
fn files_of_weights_are_read_in_blocks() {
    let folder = Folder::of(&[
        ("a.xyz", &table(9, false)),
        ("b.xyz", &table(12, true)),
        ("w.txt", &numbers(9, false)),
        ("bad.txt", &numbers(9, true)),
        ("long.csv", &format!("w\n{}", numbers(21, false))),
        ("damaged.csv", &numbers(21, true)),
        ("short.txt", &numbers(8, false)),
    ]);
    folder.write("w.npy", npy("f8", 9, 1, false, &data("f8", 9)));
    folder.write("short.npy", npy("f8", 8, 1, false, &data("f8", 8)));
    folder.write("wide.npy", npy("f8", 9, 2, false, &data("f8", 18)));
    let mut numbers = data("f8", 9);
    numbers[56..64].copy_from_slice(&f64::NAN.to_le_bytes());
    folder.write("nan.npy", npy("f8", 9, 1, false, &numbers));
    for name in
        ["w.txt", "w.npy", "bad.txt", "nan.npy", "short.txt", "short.npy", "wide.npy", "none.txt", "long.csv"]
    {
        folder.check(&["a.xyz"], &file(&folder, name, &plain()));
        folder.check(&["a.xyz"], &file(&folder, name, &skipping()));
    }
    for name in ["long.csv", "damaged.csv", "short.npy", "none.npy"] {
        for rest in [plain(), skipping()] {
            let plane = ReadOptions { dimension: Some(3), ..rest };
            folder.check(&["a.xyz", "a.xyz"], &file(&folder, name, &plane));
            folder.check(&["a.xyz", "b.xyz"], &file(&folder, name, &plane));
        }
    }
}

#[test]
fn large_files_of_weights_are_refused() {
    let folder = Folder::of(&[("a.xyz", &table(9, false)), ("w.txt", &numbers(9, false))]);
    let options = file(&folder, "w.txt", &plain());
    let limits = super::Limits { whole: 20, ..LIMITS };
    for part in super::together(&folder.paths(&["a.xyz"]), &options, 2, limits, super::even) {
        let Err(super::Ended::Refused(refused)) = part else { panic!("{part:?}") };
        assert!(refused.code == 5 && refused.message.contains("w.txt"), "{}", refused.message);
    }
}
