//! Weights of points, in columns and in files of their own.

use std::path::PathBuf;

use super::*;
use crate::read::{FileList, ListError, Place, WeightOption, WeightSource, read, read_from, read_list};

/// Options with weights of this argument.
pub(super) fn weights(argument: &str) -> ReadOptions {
    let source = WeightSource::of_argument(argument);
    ReadOptions { weights: Some(WeightOption { source, are_radii: false }), ..PLAIN }
}

fn radii(argument: &str) -> ReadOptions {
    let source = WeightSource::of_argument(argument);
    ReadOptions { weights: Some(WeightOption { source, are_radii: true }), ..PLAIN }
}

fn columns(wanted: &[&str], options: ReadOptions) -> ReadOptions {
    ReadOptions { columns: Some(wanted.iter().map(|&name| name.to_owned()).collect()), ..options }
}

fn refused(name: &str, data: impl AsRef<[u8]>, options: &ReadOptions) -> (u8, String) {
    let error = bad_with(name, data, options);
    (error.exit_code() as u8, report(&error))
}

/// A folder with files.
struct Folder(tempfile::TempDir);

impl Folder {
    fn of(files: &[(&str, &[u8])]) -> Self {
        let folder = Folder(tempfile::tempdir().unwrap());
        for (name, data) in files {
            std::fs::write(folder.path(name), data).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Reads points with a file of weights.
    fn read(&self, points: &str, weights: &str, rest: &ReadOptions) -> Result<PointFile, InputError> {
        let source = WeightSource::File(self.path(weights));
        let are_radii = rest.weights.as_ref().is_some_and(|option| option.are_radii);
        let options = ReadOptions { weights: Some(WeightOption { source, are_radii }), ..rest.clone() };
        read(&self.path(points), &options, &mut |_, _| {})
    }

    /// Returns the exit code, and the message and remedy without the folder.
    fn refused(&self, points: &str, weights: &str, rest: &ReadOptions) -> (u8, String) {
        let error = self.read(points, weights, rest).unwrap_err();
        let folder = format!("{}/", self.0.path().display());
        (error.exit_code() as u8, report(&error).replace(&folder, ""))
    }
}

#[test]
fn a_column_is_chosen_by_name_or_number() {
    let table = "x,y,Mass [kg],R2\n0,0,7,1\n2,0,8,-0.5\n";
    for (argument, expected) in
        [("R2", [1.0, -0.5]), ("r2", [1.0, -0.5]), ("4", [1.0, -0.5]), ("mass", [7.0, 8.0])]
    {
        let file = good_with("a.csv", table, &weights(argument));
        assert_eq!(file.weights.as_deref(), Some(&expected[..]), "{argument}");
        assert_eq!(plane(&file), [[0.0, 0.0], [2.0, 0.0]]);
    }
    assert_eq!(good_with("a.csv", table, &radii("mass")).weights, Some(vec![49.0, 64.0]));
}

#[test]
fn names_select_coordinates_beside_the_weights() {
    let file = good_with("a.csv", "w,z,y,x\n9,3,2,1\n", &weights("w"));
    assert_eq!((space(&file), file.weights), (vec![[1.0, 2.0, 3.0]], Some(vec![9.0])));
    assert!(noted(&file.notes, "coordinates are x, y, z, weights are w"), "{:?}", file.notes);
    assert!(file.reading.ignored.is_empty());
    // With two coordinates, z is free.
    let options = ReadOptions { dimension: Some(2), ..weights("z") };
    let file = good_with("a.csv", "x,y,z\n1,2,3\n", &options);
    assert_eq!((plane(&file), file.weights), (vec![[1.0, 2.0]], Some(vec![3.0])));
    let chosen = columns(&["y", "3"], weights("x"));
    let file = good_with("a.csv", "x,y,z\n1,2,3\n", &chosen);
    assert_eq!((plane(&file), file.weights), (vec![[2.0, 3.0]], Some(vec![1.0])));
}

#[test]
fn tables_without_names_have_coordinates_in_the_other_columns() {
    let of = |table: &str, options: &ReadOptions| good_with("a.xyz", table, options);
    let file = of("1 2 30\n4 5 60\n", &weights("3"));
    assert_eq!((plane(&file), file.weights), (vec![[1.0, 2.0], [4.0, 5.0]], Some(vec![30.0, 60.0])));
    assert!(file.notes.is_empty(), "{:?}", file.notes);
    let file = of("30 1 2\n60 4 5\n", &weights("1"));
    assert_eq!((plane(&file), file.weights), (vec![[1.0, 2.0], [4.0, 5.0]], Some(vec![30.0, 60.0])));
    let file = of("1 2 3 40\n", &weights("4"));
    assert_eq!((space(&file), file.weights), (vec![[1.0, 2.0, 3.0]], Some(vec![40.0])));
    let file = of("1 20 3 4\n", &weights("2"));
    assert_eq!((space(&file), file.weights), (vec![[1.0, 3.0, 4.0]], Some(vec![20.0])));
    let two = ReadOptions { dimension: Some(2), ..weights("1") };
    let file = of("10 2 3 4 5\n", &two);
    assert_eq!((plane(&file), file.weights), (vec![[2.0, 3.0]], Some(vec![10.0])));
    assert!(noted(&file.notes, "these columns are ignored: 4, 5"), "{:?}", file.notes);
    // A count of rows at the beginning leaves further columns to attributes.
    let file = of("2\n1 2 3 4 5\n1 2 4 4 6\n", &weights("5"));
    assert_eq!((file.points.dimension(), file.weights), (3, Some(vec![5.0, 6.0])));
    // Weights may count the rows, and the first coordinate beside weights may not.
    let file = of("0 0.5 0.25\n1 0.75 0.5\n2 1.5 0.5\n3 1.5 2.5\n", &weights("1"));
    assert_eq!(file.weights, Some(vec![0.0, 1.0, 2.0, 3.0]));
    let (code, text) = refused("a.xyz", "0 0.5 .25 7\n1 .75 .5 7\n2 1.5 .5 7\n", &weights("4"));
    assert!(code == 2 && text.contains("counts the rows") && text.contains("--columns 2,3"), "{text}");
}

#[test]
fn a_column_is_a_coordinate_or_the_weights() {
    for (table, options, part) in [
        (
            "x,y,z\n1,2,3\n",
            weights("z"),
            "column z is a coordinate, and cannot be the weights (columns: x, y, z)",
        ),
        ("x,y,z\n1,2,3\n", columns(&["x", "y"], weights("2")), "column y is a coordinate, and cannot"),
        (
            "1,2,3\n",
            columns(&["1", "3"], weights("3")),
            "column 3 is a coordinate, and cannot be the weights",
        ),
        ("x,y\n1,2\n", weights("w"), "a.csv, line 1: there is no column w (columns: x, y)"),
        ("1,2\n", weights("w"), "column w is not one of 1 to 2, and no header row names it"),
        ("x,y,W [m],w [s]\n1,2,3,4\n", weights("w"), "more than one column is named w"),
    ] {
        let options = &options;
        let (code, text) = refused("a.csv", table, options);
        assert_eq!(code, 2, "{text}");
        assert!(
            text.contains(part) && text.contains("a file of one number a row: .xyz .txt .csv .npy"),
            "{text}"
        );
    }
    let (code, text) = refused("a.xyz", "1 2 3 4 5\n", &weights("5"));
    assert!(
        code == 2 && text.contains("4 columns of numbers besides the weights without a header row"),
        "{text}"
    );
    let (code, text) = refused("a.xyz", "1 2 3\n", &ReadOptions { dimension: Some(3), ..weights("3") });
    assert!(code == 3 && text.contains("2 coordinates instead of 3"), "{text}");
    let (code, text) = refused("a.xyz", "1 2\n", &weights("2"));
    assert!(code == 3 && text.contains("dimension 1 is not supported (supported: 2 to 6)"), "{text}");
    let (code, text) = refused("a.xyz", "1 2 3\n4 5\n", &weights("3"));
    assert!(code == 3 && text.contains("at least 3 columns"), "{text}");
}

#[test]
fn bad_weights_are_errors_with_their_row() {
    for (table, options, part) in [
        (
            "1 2 3\n\n1 2 nan\n",
            weights("3"),
            "a.xyz, line 3: weight of point 1 (from 0) is NaN, not a finite number\n",
        ),
        (
            "1 2 -inf\n",
            radii("3"),
            "a.xyz, line 1: radius of point 0 (from 0) is -inf, not a finite number\n",
        ),
        (
            "1 2 3\n4 5 -1\n",
            radii("3"),
            "line 2: radius of point 1 (from 0) is -1.0, not a radius, which is 0 or more\n",
        ),
        ("1 2 1e200\n", radii("3"), "is 1e200, too large: its square is infinite\n"),
        ("1 2 3\n4 5 x\n", weights("3"), "a.xyz, line 2, column 5: found \"x\", expected"),
    ] {
        let error = bad_with("a.xyz", table, &options);
        let text = report(&error);
        assert!(text.contains(part), "{text}");
        assert_eq!(error.exit_code() as u8, 3);
        assert!(error.row().is_some() && error.line().is_some(), "{text}");
    }
    let table = "x,y,r,m\n1,2,3,0\n4,5,-1,1\n6,7,,2\nnan,1,1,3\n8,9,nan,4\n1,1,x,5\n2,2,4,6\n";
    let skip = ReadOptions { skip_invalid: true, keep_columns: true, ..radii("r") };
    let file = good_with("a.csv", table, &skip);
    assert_eq!((file.weights.as_deref(), file.skipped), (Some(&[9.0, 16.0][..]), 5));
    assert_eq!(
        (file.source_index.as_deref(), plane(&file)),
        (Some(&[0, 6][..]), vec![[1.0, 2.0], [2.0, 2.0]])
    );
    let masses = file.columns.iter().find(|column| column.name == "m").unwrap();
    assert_eq!(masses.values, [0.0, 6.0]);
    // The smallest weight that is no number of points: -0.0 is 0.0.
    let file = good_with("a.xyz", "1 2 -0.0\n", &weights("3"));
    assert_eq!(file.weights.unwrap()[0].to_bits(), 0.0_f64.to_bits());
}

/// An array of these numbers in rows of `columns`.
fn array(columns: usize, numbers: &[f64], fortran: bool) -> Vec<u8> {
    let (rows, order) = (numbers.len() / columns, if fortran { "True" } else { "False" });
    let shape = format!("({rows}, {columns})");
    let header = format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    npy(&header, &bytes_of!(f64, to_le_bytes, numbers))
}

fn vector(numbers: &[f64]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}\n", numbers.len());
    npy(&header, &bytes_of!(f64, to_le_bytes, numbers))
}

#[test]
fn arrays_have_a_column_more() {
    let numbers = [1.0, 2.0, 30.0, 4.0, 5.0, 60.0];
    let file = good_with("a.npy", array(3, &numbers, false), &weights("3"));
    assert_eq!((plane(&file), file.weights), (vec![[1.0, 2.0], [4.0, 5.0]], Some(vec![30.0, 60.0])));
    let file = good_with("a.npy", array(3, &numbers, false), &weights("1"));
    assert_eq!((plane(&file), file.weights), (vec![[2.0, 30.0], [5.0, 60.0]], Some(vec![1.0, 4.0])));
    let numbers = [1.0, 5.0, 2.0, 6.0, 3.0, 7.0, 9.0, 8.0];
    let file = good_with("a.npy", array(4, &numbers, true), &radii("4"));
    assert_eq!(space(&file), [[1.0, 2.0, 3.0], [5.0, 6.0, 7.0]]);
    assert_eq!(file.weights, Some(vec![81.0, 64.0]));
    let two = ReadOptions { dimension: Some(2), ..weights("2") };
    let file = good_with("a.npy", array(4, &[1.0, 2.0, 3.0, 4.0], false), &two);
    assert_eq!((plane(&file), file.weights), (vec![[1.0, 3.0]], Some(vec![2.0])));
    for (columns, argument, code, part) in [
        (3, "4", 2, "column 4 is not one of 1 to 3"),
        (3, "w", 2, "column w is not one of 1 to 3"),
        (5, "5", 3, "points of dimension 4 have no weights"),
        (8, "5", 3, "an array of shape (1, 8) as points with weights"),
        (2, "2", 3, "an array of shape (1, 2) as points with weights"),
    ] {
        let (found, text) = refused("a.npy", array(columns, &vec![1.0; columns], false), &weights(argument));
        assert!(found == code && text.contains(part), "{text}");
    }
    let data = array(3, &[1.0, 2.0, 3.0, 4.0, 5.0, f64::NAN], false);
    let start = data.len() - 8;
    let error = bad_with("a.npy", &data, &weights("3"));
    assert_eq!((error.place(), error.row()), (Place::Byte(start as u64), Some(1)));
    let skip = ReadOptions { skip_invalid: true, ..weights("3") };
    let file = good_with("a.npy", &data, &skip);
    assert_eq!((file.weights, file.skipped), (Some(vec![3.0]), 1));
}

#[test]
fn fields_of_arrays_are_named() {
    let header =
        "{'descr': [('w', '<f4'), ('x', '<f8'), ('y', '<f8')], 'fortran_order': False, 'shape': (1,), }\n";
    let data = [2.5_f32.to_le_bytes().to_vec(), bytes_of!(f64, to_le_bytes, [1.0, 2.0])].concat();
    let file = good_with("a.npy", npy(header, &data), &weights("W"));
    assert_eq!((plane(&file), file.weights), (vec![[1.0, 2.0]], Some(vec![2.5])));
    for (argument, part) in
        [("v", "there is no field v of numbers (columns: w, x, y)"), ("x", "the field x is a coordinate")]
    {
        let (code, text) = refused("a.npy", npy(header, &data), &weights(argument));
        assert!(code == 2 && text.contains(part), "{text}");
    }
}

#[test]
fn formats_without_columns_are_refused_by_name() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nproperty double z\nend_header\n1 2 3\n";
    let (code, text) = refused("a.ply", ply, &weights("w"));
    assert_eq!(code, 2);
    assert_eq!(
        text,
        "a.ply: a .ply file has no column of weights\ncolumns of weights are read from .xyz .txt .csv .npy .npz; \
         otherwise give a file of one number a row: .xyz .txt .csv .npy (each also with .gz)"
    );
    let raw = ReadOptions { raw: Some("f64,2".parse().unwrap()), ..weights("w") };
    let error = read_from(&[0; 16][..], Path::new("a.bin"), None, &raw, &mut |_, _| {}).unwrap_err();
    assert!(error.to_string().contains("a .raw file has no column of weights"), "{error}");
    let terrain = ReadOptions { terrain: true, ..weights("w") };
    let error = read_from(&b"x,y,z,w\n1,2,3,4\n"[..], Path::new("a.csv"), None, &terrain, &mut |_, _| {});
    let error = error.unwrap_err();
    assert_eq!((error.exit_code() as u8, report(&error).lines().count()), (2, 2));
    assert_eq!(error.to_string(), "a.csv: the points of a terrain have no weights");
}

#[test]
fn atoms_have_weights_in_numbered_columns() {
    let atoms = "2\nwater\nO 0 0 0.5 1.5\nH 1 0 0 1.2\n";
    let file = good_with("a.xyz", atoms, &radii("5"));
    assert_eq!(file.weights, Some(vec![1.5 * 1.5, 1.2 * 1.2]));
    assert_eq!(space(&file), [[0.0, 0.0, 0.5], [1.0, 0.0, 0.0]]);
    for (argument, part) in
        [("3", "column 3 is a coordinate"), ("6", "column 6 is not one of 1 to 5"), ("r", "column r is not")]
    {
        let (code, text) = refused("a.xyz", atoms, &weights(argument));
        assert!(code == 2 && text.contains(part), "{text}");
    }
}

#[test]
fn files_of_weights_have_a_number_a_row() {
    let numbers = [1.0, -2.5, 3.0];
    let folder = Folder::of(&[
        ("p.csv", b"x,y\n0,0\n1,0\n0,1\n"),
        ("w.txt", b"# weights\n1\n-2.5 # here\n\n3\n"),
        ("w.csv", b"w\n1\n\"-2.5\"\n3\n"),
        ("w.dat", b"1\r\n-2.5\r\n3"),
        ("w.npy", &vector(&numbers)),
        ("one.npy", &array(1, &numbers, false)),
        ("text.npy", b"1\n2\n3\n"),
        ("wide.npy", &array(3, &[1.0; 9], false)),
        ("wide.csv", b"1,2\n1,2\n1,2\n"),
        ("w.vtu", b"<VTKFile/>"),
        ("w.npz", b"PK\x03\x04"),
        ("short.txt", b"1\n2\n"),
        ("long.npy", &vector(&[1.0; 4])),
        ("bad.txt", b"1\n\nx\n3\n"),
        ("nan.npy", &vector(&[1.0, f64::NAN, 3.0])),
        ("negative.txt", b"1\n-2\n3\n"),
    ]);
    for name in ["w.txt", "w.csv", "w.dat", "w.npy", "one.npy"] {
        let file = folder.read("p.csv", name, &PLAIN).unwrap();
        assert_eq!((file.weights.as_deref(), file.skipped), (Some(&numbers[..]), 0), "{name}");
    }
    for (name, code, part) in [
        ("none.txt", 3, "none.txt: no such file"),
        ("short.txt", 3, "short.txt: 2 weights for 3 rows of points\ngive one number for each row of points"),
        ("long.npy", 3, "long.npy: 4 weights for 3 rows of points"),
        ("bad.txt", 3, "bad.txt, line 3, column 1: found \"x\", expected"),
        ("nan.npy", 3, "weight of point 1 (from 0) is NaN, not a finite number"),
        ("wide.csv", 3, "wide.csv, line 1: found \"1,2\", expected one number"),
        (
            "wide.npy",
            3,
            "an array of weights with rows of 3 is not supported\nsave one number a row: an array of shape (n,)",
        ),
        ("text.npy", 3, "magic"),
        (
            "w.vtu",
            3,
            "a .vtu file of weights is not supported\ngive one number a row as one of .xyz .txt .csv .npy",
        ),
        ("w.npz", 3, "a .npz file of weights is not supported\nsave the array with numpy.save as .npy"),
    ] {
        let (found, text) = folder.refused("p.csv", name, &PLAIN);
        assert!(found == code && text.contains(part), "{text}");
    }
    let (_, text) = folder.refused("p.csv", "negative.txt", &radii("r"));
    assert!(
        text.starts_with("negative.txt, line 2: radius of point 1 (from 0) is -2.0, not a radius"),
        "{text}"
    );
}

#[test]
fn rows_stay_aligned_when_some_are_dropped() {
    let folder = Folder::of(&[
        ("p.csv", b"x,y,m\n0,0,0\nnan,0,1\n0,1,2\n1,1,3\n2,2,4\n"),
        ("w.txt", b"10\n11\n12\nnan\n14\n"),
        ("all.txt", b"10\n11\n12\n13\n14\n"),
        ("few.txt", b"10\n12\n13\n14\n"),
    ]);
    let skip = ReadOptions { keep_columns: true, ..SKIP };
    let file = folder.read("p.csv", "all.txt", &skip).unwrap();
    assert_eq!(
        (file.weights.unwrap(), file.source_index.unwrap()),
        (vec![10.0, 12.0, 13.0, 14.0], vec![0, 2, 3, 4])
    );
    let file = folder.read("p.csv", "w.txt", &skip).unwrap();
    assert_eq!(file.weights.as_deref(), Some(&[10.0, 12.0, 14.0][..]));
    assert_eq!((file.skipped, file.source_index.as_deref()), (2, Some(&[0, 2, 4][..])));
    assert_eq!((plane(&file).len(), &file.columns[0].values[..]), (3, &[0.0, 2.0, 4.0][..]));
    let (code, text) = folder.refused("p.csv", "few.txt", &skip);
    assert!(code == 3 && text.starts_with("few.txt: 4 weights for 5 rows of points"), "{text}");
}

#[test]
fn lists_have_columns_in_each_file_and_one_file_of_weights() {
    let folder = Folder::of(&[
        ("a.csv", b"x,y,w\n0,0,1\n1,0,2\n"),
        ("b.xyz", b"0 1 3\n"),
        ("c.csv", b"w,x,y\n"),
        ("w.txt", b"7\n8\n9\n"),
        ("bad.txt", b"7\n8\nnan\n"),
        ("d.csv", b"x,y,v\n0,0,1\n"),
    ]);
    let read = |names: &[&str], options: &ReadOptions| {
        let list = FileList::new(names.iter().map(|name| folder.path(name)).collect());
        read_list(&list, options, &mut |_, _| {})
    };
    let file = |name: &str| weights(folder.path(name).to_str().unwrap());
    let list = read(&["a.csv", "b.xyz"], &weights("3")).unwrap();
    assert_eq!(list.content.weights, Some(vec![1.0, 2.0, 3.0]));
    assert_eq!(read(&["c.csv", "a.csv"], &weights("w")).unwrap().content.weights, Some(vec![1.0, 2.0]));
    assert!(
        read(&["a.csv", "d.csv"], &weights("w")).unwrap_err().to_string().contains("there is no column w")
    );
    let plane = ReadOptions { dimension: Some(2), ..file("w.txt") };
    let list = read(&["a.csv", "b.xyz"], &plane).unwrap();
    assert_eq!(list.content.weights, Some(vec![7.0, 8.0, 9.0]));
    let error = read(&["a.csv", "a.csv"], &plane).unwrap_err();
    assert_eq!(
        (error.exit_code() as u8, error.to_string().ends_with("w.txt: 3 weights for 4 rows of points")),
        (3, true)
    );
    let bad = ReadOptions { dimension: Some(2), ..file("bad.txt") };
    let error = read(&["a.csv", "b.xyz"], &bad).unwrap_err();
    assert!(matches!(error, ListError::Weights { .. }) && error.row() == Some(2), "{error}");
    let skip = ReadOptions { skip_invalid: true, ..bad };
    let list = read(&["a.csv", "b.xyz"], &skip).unwrap();
    assert_eq!((list.content.weights, list.content.source_index), (Some(vec![7.0, 8.0]), Some(vec![0, 1])));
}
