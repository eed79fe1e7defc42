//! Tests of lists of files.

use std::fs;
use std::path::PathBuf;

use glam::DVec3;
use septet_core::model::Points;
use tempfile::TempDir;

use super::super::{CoordinateType, InputError, PointFile, ReadOptions, read};
use super::{EntryFault, FileList, ListError, PointList, read_list};

/// Points of eight rows in three parts.
const PARTS: [(&str, &str); 3] = [
    ("part-1.xyz", "0 0 0\n4 0 0\n0 4 0\n"),
    ("part-10.csv", "z,y,x\n4,0,0\n1,1,1\n"),
    ("part-2.xyz", "2 1 1\n1 2 1\n1 1 2\n"),
];

/// A folder with files.
struct Folder(TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Folder(tempfile::tempdir().unwrap());
        for (name, text) in files {
            folder.write(name, text);
        }
        folder
    }

    fn write(&self, name: &str, data: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, data).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The list that an argument names, relative to the folder. `@` comes first.
    fn list(&self, argument: &str) -> Result<Option<FileList>, ListError> {
        let (at, name) = argument.strip_prefix('@').map_or(("", argument), |name| ("@", name));
        FileList::of_argument(&format!("{at}{}", self.path(name).display()))
    }

    /// The names of the files of a list, relative to the folder.
    fn names(&self, argument: &str) -> Vec<String> {
        let list = self.list(argument).unwrap().unwrap();
        let name = |file: &PathBuf| file.strip_prefix(self.0.path()).unwrap().display().to_string();
        list.files().iter().map(name).collect()
    }

    fn entry(&self, list: &[u8]) -> (u64, EntryFault) {
        self.write("list.txt", list);
        match self.list("@list.txt") {
            Err(ListError::Entry { line, fault, .. }) => (line, fault),
            other => panic!("{other:?}"),
        }
    }

    fn read(&self, names: &[&str], options: &ReadOptions) -> Result<PointList, ListError> {
        let files = names.iter().map(|name| self.path(name)).collect();
        read_list(&FileList::new(files), options, &mut |_, _| {})
    }

    fn good(&self, names: &[&str]) -> PointList {
        self.read(names, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
    }

    fn bad(&self, names: &[&str]) -> ListError {
        self.read(names, &ReadOptions::default()).unwrap_err()
    }

    fn single(&self, name: &str, options: &ReadOptions) -> PointFile {
        read(&self.path(name), options, &mut |_, _| {}).unwrap()
    }
}

/// A `.npy` file of rows of three numbers.
fn npy(kind: &str, data: &[u8], rows: usize) -> Vec<u8> {
    let header = format!("{{'descr': '<{kind}', 'fortran_order': False, 'shape': ({rows}, 3), }}\n");
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.bytes());
    file.extend(data);
    file
}

fn doubles(values: &[f64]) -> Vec<u8> {
    npy("f8", &values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>(), values.len() / 3)
}

fn floats(values: &[f32]) -> Vec<u8> {
    npy("f4", &values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>(), values.len() / 3)
}

#[test]
fn a_pattern_names_files_in_byte_order() {
    let folder = Folder::new(&PARTS);
    folder.write(".part-0.xyz", "");
    folder.write("part-3.xyz/inner.xyz", "");
    assert_eq!(folder.names("part-*"), ["part-1.xyz", "part-10.csv", "part-2.xyz"]);
    assert_eq!(folder.names("part-?.xyz"), ["part-1.xyz", "part-2.xyz"]);
    assert_eq!(folder.names("part-[!1]*"), ["part-2.xyz"]);
    assert_eq!(folder.names(".part*"), [".part-0.xyz"]);
    assert_eq!(folder.names("part-3.xyz/*"), ["part-3.xyz/inner.xyz"]);
    assert!(matches!(folder.list("x*"), Err(ListError::NoMatch { .. })));
    assert!(matches!(folder.list("absent/x*"), Err(ListError::Folder { .. })));
    assert!(matches!(folder.list("part**"), Err(ListError::Pattern { .. })));
}

#[test]
fn other_names_are_single_files() {
    let folder = Folder::new(&[("a[1].xyz", ""), ("what?.xyz", "")]);
    for name in ["a[1].xyz", "what?.xyz", "plain.xyz", "a[1.xyz", "*/plain.xyz"] {
        assert_eq!(folder.list(name).unwrap(), None, "{name}");
        assert!(!FileList::is_named_by(&folder.path(name).display().to_string()), "{name}");
    }
    for name in ["-", "", "@", ".", "..", "/"] {
        assert_eq!(FileList::of_argument(name).unwrap(), None, "{name}");
    }
    assert!(FileList::is_named_by("@list.txt") && FileList::is_named_by("x-*.npy"));
}

#[test]
fn a_list_names_files_relative_to_its_folder() {
    let folder = Folder::new(&PARTS);
    folder.write("sub/list.txt", "\u{feff}# parts\r\n\r\n  ../part-2.xyz \r\n../part-1.xyz\n# end");
    assert_eq!(folder.names("@sub/list.txt"), ["sub/../part-2.xyz", "sub/../part-1.xyz"]);
    let list = folder.list("@sub/list.txt").unwrap().unwrap();
    assert_eq!(list.source(), Some(folder.path("sub/list.txt").as_path()));
    let absolute = folder.path("part-1.xyz");
    folder.write("list.txt", absolute.display().to_string());
    assert_eq!(folder.list("@list.txt").unwrap().unwrap().files(), [absolute]);
}

#[test]
fn a_faulty_line_of_a_list_is_refused() {
    let folder = Folder::new(&PARTS);
    let missing = EntryFault::Missing { path: folder.path("gone.xyz") };
    assert_eq!(folder.entry(b"# x\npart-1.xyz\ngone.xyz\n"), (3, missing));
    assert_eq!(folder.entry(b"part-1.xyz\n-\n"), (2, EntryFault::StandardInput));
    assert_eq!(folder.entry(b"./list.txt\n"), (1, EntryFault::Itself));
    assert_eq!(folder.entry(b"@list.txt\n"), (1, EntryFault::Itself));
    assert_eq!(folder.entry(b"@part-1.xyz\n"), (1, EntryFault::List));
    assert_eq!(folder.entry(b".\n"), (1, EntryFault::Folder));
    assert_eq!(folder.entry(b"part-1.xyz\n\xff\n"), (2, EntryFault::NotUtf8));
    folder.write("list.txt", "# nothing\n\n");
    assert!(matches!(folder.list("@list.txt"), Err(ListError::NoEntry { .. })));
    let Err(ListError::List { error }) = folder.list("@absent.txt") else { panic!("read") };
    assert!(matches!(*error, InputError::Missing { .. }), "{error}");
}

#[test]
fn rows_are_numbered_across_the_files() {
    let folder = Folder::new(&PARTS);
    folder.write("empty.xyz", "");
    folder.write("header.csv", "x,y,z\n");
    let names = ["empty.xyz", "part-1.xyz", "header.csv", "part-10.csv", "part-2.xyz", "empty.xyz"];
    let all = folder.good(&names);
    folder.write("whole.xyz", "0 0 0\n4 0 0\n0 4 0\n0 0 4\n1 1 1\n2 1 1\n1 2 1\n1 1 2\n");
    assert_eq!(all.content.points, folder.single("whole.xyz", &ReadOptions::default()).points);
    let rows: Vec<_> = all.files.iter().map(|file| (file.first_row, file.rows)).collect();
    assert_eq!(rows, [(0, 0), (0, 3), (3, 0), (3, 2), (5, 3), (8, 0)]);
    for (row, name) in [(0, "part-1.xyz"), (2, "part-1.xyz"), (3, "part-10.csv"), (7, "part-2.xyz")] {
        assert_eq!(all.file_of(row).map(|file| file.path.as_path()), Some(folder.path(name).as_path()));
    }
    assert_eq!(all.file_of(8), None);
}

#[test]
fn no_files_and_files_without_points_have_no_points() {
    let folder = Folder::new(&[("a.xyz", ""), ("b.csv", "x,y,z\n")]);
    folder.write("c.npy", doubles(&[]));
    for names in [&[][..], &["a.xyz", "b.csv"], &["b.csv", "c.npy"]] {
        let all = folder.good(names);
        assert_eq!(all.content.points, Points::Space(Vec::new()));
        assert_eq!(all.files.len(), names.len());
    }
    let plane = ReadOptions { dimension: Some(2), ..ReadOptions::default() };
    assert_eq!(folder.read(&["b.csv"], &plane).unwrap().content.points, Points::Plane(Vec::new()));
}

#[test]
fn dropped_points_count_as_rows() {
    let folder =
        Folder::new(&[("a.xyz", "0 0 0\nnan 0 0\n"), ("b.xyz", "1 0 0\n"), ("c.xyz", "x 0 0\n0 2 0\n")]);
    let skip = ReadOptions { skip_invalid: true, ..ReadOptions::default() };
    let all = folder.read(&["b.xyz", "a.xyz", "b.xyz", "c.xyz"], &skip).unwrap().content;
    assert_eq!(all.source_index, Some(vec![0, 1, 3, 5]));
    assert_eq!(all.skipped, 2);
    let points = [[1.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(DVec3::from);
    assert_eq!(all.points, Points::Space(points.to_vec()));
}

#[test]
fn an_error_gives_the_row_in_the_file_and_in_the_list() {
    let folder = Folder::new(&[("a.xyz", "0 0 0\n1 0 0\n"), ("short.xyz", "# x\n0 0 0\n1 1\n")]);
    folder.write("nan.npy", doubles(&[0.0, 0.0, 0.0, 1.0, f64::NAN, 0.0]));
    folder.write("word.csv", "x,y,z\n1,2,3\n1,2,3\n1,a,3\n");
    folder.write("word.node", "2 3\n1 0 0 0\n2 0 b 0\n");
    for (name, own, place) in [
        ("nan.npy", 1, "byte"),
        ("short.xyz", 1, "line 3"),
        ("word.csv", 2, "line 4"),
        ("word.node", 1, "line 3"),
    ] {
        let error = folder.bad(&["a.xyz", "a.xyz", name]);
        assert_eq!(error.row(), Some(4 + own), "{error}");
        let text = error.to_string();
        let start = format!("row {} of the list, row {own} of its file (both from 0): ", 4 + own);
        assert!(text.starts_with(&start) && text.contains(name) && text.contains(place), "{text}");
    }
    folder.write("torn.npy", b"\x93NUM");
    let error = folder.bad(&["a.xyz", "torn.npy"]);
    assert!(error.row().is_none() && error.to_string().contains("torn.npy"), "{error}");
}

#[test]
fn files_of_other_dimension_or_type_are_refused() {
    let folder = Folder::new(&[("plane.xyz", "0 0\n1 0\n"), ("space.xyz", "0 0 0\n")]);
    folder.write("f8.npy", doubles(&[1.0; 3]));
    folder.write("f4.npy", floats(&[1.0; 3]));
    folder.write("none.npy", floats(&[]));
    folder.write("i8.npy", npy("i8", &[0; 24], 1));
    folder.write("i2.npy", npy("i2", &[0; 6], 1));
    let error = folder.bad(&["space.xyz", "plane.xyz"]);
    assert!(matches!(error, ListError::MixedDimension { found: 2, expected: 3, .. }), "{error}");
    assert!(error.to_string().starts_with(&folder.path("plane.xyz").display().to_string()), "{error}");
    let plane = ReadOptions { dimension: Some(2), ..ReadOptions::default() };
    assert_eq!(folder.read(&["space.xyz", "plane.xyz"], &plane).unwrap().content.points.len(), 3);
    for (first, second) in
        [("f8.npy", "f4.npy"), ("f4.npy", "f8.npy"), ("f8.npy", "i8.npy"), ("i2.npy", "f4.npy")]
    {
        let error = folder.bad(&[first, "space.xyz", second]);
        let ListError::MixedTypes { path, .. } = &error else { panic!("{error}") };
        assert!(path.ends_with(second) && error.to_string().contains(first), "{error}");
    }
    for names in [&["f8.npy", "none.npy"][..], &["i8.npy", "i2.npy"], &["f4.npy", "space.xyz", "f4.npy"]] {
        folder.good(names);
    }
    assert_eq!(folder.good(&["space.xyz", "f4.npy"]).content.coordinate_type, Some(CoordinateType::Float32));
}

#[test]
fn kept_columns_are_joined_by_name() {
    let folder = Folder::new(&[
        ("a.csv", "x,y,z,mass,id\n0,0,0,5,1\n1,0,0,6,2\n"),
        ("b.csv", "id,mass,x,y,z\n3,7,0,1,0\n"),
        ("none.csv", "x,y,z\n"),
        ("other.csv", "x,y,z,mass\n0,0,0,5\n"),
    ]);
    let keep = ReadOptions { keep_columns: true, ..ReadOptions::default() };
    let all = folder.read(&["none.csv", "a.csv", "none.csv", "b.csv"], &keep).unwrap().content;
    let columns: Vec<_> = all.columns.iter().map(|c| (c.name.as_str(), c.values.as_slice())).collect();
    assert_eq!(columns, [("mass", &[5.0, 6.0, 7.0][..]), ("id", &[1.0, 2.0, 3.0])]);
    let error = folder.read(&["a.csv", "other.csv"], &keep).unwrap_err();
    let ListError::MixedColumns { path, found, expected, .. } = &error else { panic!("{error}") };
    assert!(path.ends_with("other.csv") && *found == ["mass"] && *expected == ["mass", "id"], "{error}");
    folder.good(&["a.csv", "other.csv"]);
}

#[test]
fn ids_begin_at_one_only_if_they_do_in_all_files() {
    let folder = Folder::new(&[("one.node", "1 2\n1 0 0\n"), ("zero.node", "1 2\n0 0 0\n"), ("a.xyz", "")]);
    for (names, first) in [
        (&["one.node", "a.xyz", "one.node"][..], 1),
        (&["one.node", "zero.node"], 0),
        (&["zero.node", "one.node"], 0),
    ] {
        assert_eq!(folder.good(names).content.first_id, first, "{names:?}");
    }
}

#[test]
fn a_note_on_several_files_is_given_once() {
    let folder = Folder::new(&[("a.csv", "x,y\n0,0\n"), ("b.csv", "x,y\n0,1\n"), ("c.csv", "y,x\n0,1\n")]);
    let notes = folder.good(&["a.csv", "c.csv", "b.csv", "b.csv"]).content.notes;
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].contains("a.csv and 3 other files: line 1 is taken as a header row"), "{notes:?}");
}

#[test]
fn the_progress_counts_the_bytes_of_all_files() {
    let folder = Folder::new(&PARTS);
    let files: Vec<PathBuf> = PARTS.iter().map(|(name, _)| folder.path(name)).collect();
    let total = PARTS.iter().map(|(_, text)| text.len() as u64).sum::<u64>();
    let mut steps = Vec::new();
    let mut progress = |done: u64, of: Option<u64>| steps.push((done, of));
    read_list(&FileList::new(files), &ReadOptions::default(), &mut progress).unwrap();
    assert!(steps.is_sorted() && steps.last() == Some(&(total, Some(total))), "{steps:?}");
}

#[test]
fn memory_is_reserved_once_for_equal_files() {
    let rows: Vec<f64> = (0..3000).map(f64::from).collect();
    let folder = Folder::new(&[]);
    let names: Vec<String> = (0..40).map(|i| format!("{i:02}.npy")).collect();
    for name in &names {
        folder.write(name, doubles(&rows));
    }
    let all = folder.good(&names.iter().map(String::as_str).collect::<Vec<_>>());
    let Points::Space(points) = &all.content.points else { panic!("dimension") };
    assert_eq!(points.len(), 40_000);
    assert!(points.capacity() <= 40_100, "{}", points.capacity());
}
