//! Text tables: columns by name, by number and by position, kept columns, counts, recognition by content.

use super::*;

fn columns(wanted: &[&str]) -> ReadOptions {
    ReadOptions { columns: Some(wanted.iter().map(|&name| name.to_owned()).collect()), ..PLAIN }
}

fn refused(data: &str, options: &ReadOptions) -> String {
    let error = bad_with("a.csv", data, options);
    assert!(matches!(error, InputError::Columns { .. }) && error.is_usage(), "{error}");
    report(&error)
}

#[test]
fn names_of_coordinates_select_their_columns() {
    let want = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
    for text in [
        "x,y,z\n1,2,3\n4,5,6\n",
        "z,y,x\n3,2,1\n6,5,4\n",
        "id,x,y,z\n9,1,2,3\n8,4,5,6\n",
        "name,x,y,z\nA,1,2,3\nB,4,5,6\n",
        "\"X [m]\";'Y (m)';\"Z\";mass\n1;2;3;0\n4;5;6;0\n",
        "# a comment\nid X[m] Y[m] Z[m]\n1 1 2 3\n2 4 5 6\n",
        "x [m] y [m] z [m]\n1 2 3\n4 5 6\n",
        ",x,y,z\n0,1,2,3\n1,4,5,6\n",
        "\"note\",\"x\",\"y\",\"z\"\n\"a, b; # c\",\"1\",\"2\",\"3\"\n,4,\"5\",6\n",
        "\"1\",\"2\",\"3\"\n\"4\",\"5\",\"6\"\n",
    ] {
        assert_eq!(space(&good("a.csv", text)), want, "{text}");
    }
    assert_eq!(plane(&good("a.csv", "value,y,x\n7,2,1\n")), [[1.0, 2.0]]);
    assert_eq!(plane(&good_with("a.csv", "id,z,y,x\n7,3,2,1\n", &TWO)), [[1.0, 2.0]]);
    let notes = good("a.csv", "id,x,y,z\n9,1,2,3\n").notes;
    assert_eq!(notes, ["line 1 is taken as a header row: coordinates are x, y, z; column id is ignored"]);
}

#[test]
fn only_names_of_axes_are_coordinates() {
    for text in
        ["lon,lat\n1,2\n", "lat,lon\n2,1\n", "id,Northing,Easting\n7,2,1\n", "t,Points:0,Points:1\n0,1,2\n"]
    {
        assert_eq!(plane(&good("a.csv", text)), [[1.0, 2.0]], "{text}");
    }
    assert_eq!(plane(&good("a.csv", ",lon,lat\n0,1,2\n")), [[1.0, 2.0]]);
    for text in [
        "id,ra,dec,z\n1,2,3,4\n",
        "id,ra,dec\n1,2,3\n",
        "ra,dec,z\n1,2,3\n",
        "a,b,c,d\n1,2,3,4\n",
        "x,x,y\n1,2,3\n",
        "who,a,b,c\nme,1,2,3\n",
        "a,b,c\n1,2,3\n",
        "P,N,E,Z,D\n1,2,3,4,tree\n",
    ] {
        let message = refused(text, &PLAIN);
        assert!(message.contains("line 1") && message.contains("--columns"), "{message}");
    }
    let message = refused("id,ra,dec,z\n1,2,3,4\n", &PLAIN);
    assert!(message.contains("columns: id, ra, dec, z") && !message.contains("such as"), "{message}");
    refused("x,y,w\n1,2,3\n", &THREE);
    refused("a,b,c\n1,2,3\n", &TWO);
}

#[test]
fn columns_are_chosen_by_name_and_by_number() {
    let text = "id,RA (deg),dec,z\n1,2,3,4\n5,6,7,8\n";
    let want = [[2.0, 3.0, 4.0], [6.0, 7.0, 8.0]];
    for wanted in [["ra", "dec", "z"], ["RA (deg)", "Dec", "Z"], ["2", "3", "4"], ["2", "dec", "4"]] {
        assert_eq!(space(&good_with("a.csv", text, &columns(&wanted))), want, "{wanted:?}");
    }
    assert_eq!(plane(&good_with("a.csv", text, &columns(&["4", "id"]))), [[4.0, 1.0], [8.0, 5.0]]);
    assert_eq!(
        plane(&good_with("a.txt", "A 1 2 3\nB 4 5 6\n", &columns(&["4", "2"]))),
        [[3.0, 1.0], [6.0, 4.0]]
    );
    for (text, wanted, part) in [
        (text, &["ra", "nothing"][..], "there is no column nothing"),
        (text, &["ra"], "1 column instead of two to six"),
        (text, &["7", "1"], "there is no column 7"),
        ("1 2 3\n", &["a", "b"], "not one of 1 to 3"),
        ("a,a,b\n1,2,3\n", &["A", "b"], "more than one"),
    ] {
        let message = refused(text, &columns(wanted));
        assert!(message.contains(part), "{message}");
    }
    let three = ReadOptions { dimension: Some(3), ..columns(&["1", "2"]) };
    refused(text, &three);
    let npy = columns(&["1", "2"]);
    assert!(matches!(bad_with("a.npy", npy_f8(), &npy), InputError::NotATable { .. }));
}

#[test]
fn rows_of_a_named_table_have_its_columns() {
    let error = bad("a.csv", "id,x,y,z\n1,2,3,4\n1,2,3\n");
    assert!(error.line() == Some(3) && error.to_string().contains("at least 4 columns"), "{error}");
    assert_eq!(bad("a.csv", "id,x,y,z\n1,2,3,\n").line(), Some(2));
    let text = "x,w,y\n1,a,2\nnan,b,2\n3,c,oops\n4,d,5\n6,e,\n";
    let file = good_with("a.csv", text, &SKIP);
    assert_eq!((plane(&file), file.source_index), (vec![[1.0, 2.0], [4.0, 5.0]], Some(vec![0, 3])));
    let error = bad("a.csv", "A,1,2,3\nB,4,5,6\n");
    assert!(report(&error).ends_with("such as --columns 2,3,4"), "{error}");
}

#[test]
fn other_columns_are_kept() {
    let keep = ReadOptions { keep_columns: true, ..SKIP };
    let text = "id,x,name,y,id\n1,2,a,3,0.5\n4,nan,b,5,1\n6,7,c,8,\n";
    let file = good_with("a.csv", text, &keep);
    assert_eq!(plane(&file), [[2.0, 3.0], [7.0, 8.0]]);
    let names: Vec<&str> = file.columns.iter().map(|c| c.name.as_str()).collect();
    assert_eq!((names, &file.columns[0].values[..]), (vec!["id_1", "id_5"], &[1.0, 6.0][..]));
    assert!(file.columns[1].values[0] == 0.5 && file.columns[1].values[1].is_nan());
    assert!(noted(&file.notes, "column name has text and is not kept"), "{:?}", file.notes);
    let keep = ReadOptions { dimension: Some(3), ..keep };
    let bare = good_with("a.txt", "1,2,3,4,5\n6,7,8,9\n", &keep);
    assert_eq!((bare.columns[0].name.as_str(), &bare.columns[0].values[..]), ("column_4", &[4.0, 9.0][..]));
    assert!(bare.columns[1].values[1].is_nan() && bare.notes.is_empty(), "{:?}", bare.notes);
    assert!(good("a.csv", text.replace("nan", "0")).columns.is_empty());
}

#[test]
fn a_table_without_numbers_is_refused() {
    for text in ["hello world\n", "hello\n", "a,b,c\n", "id,x\n"] {
        let error = bad("a.xyz", text);
        assert!(matches!(error, InputError::Syntax { line: 1, .. }), "{error}");
    }
    assert_eq!(bad("a.xyz", "hello world\nand more words\n").line(), Some(2));
    for text in ["x,y,z\n", "name x y z\n", "# c\ny,x\n\n"] {
        let error = bad("a.csv", text);
        assert!(matches!(error, InputError::NoRows { .. }) && !error.is_usage(), "{error}");
        assert!(error.to_string().contains("a header and no rows"), "{error}");
    }
    assert_eq!(good("a.csv", "").points.len(), 0);
}

#[test]
fn a_leading_count_is_checked() {
    let file = good("a.pts", "2\n1 2 3\n4 5 6\n");
    assert_eq!(space(&file), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert!(noted(&file.notes, "number of points"));
    // Further columns are values, unless the file states its dimension.
    assert_eq!(good("a.pts", "1\n1 2 3 90\n").points.dimension(), 3);
    for text in [
        "4 rbox\n2\n1 2 3 0.5\n5 6 7 0.5\n",
        "2\n4\n1 2 3 0.5\n5 6 7 0.5\n",
        "3 4 0\n1 2 3 0.5\n5 6 7 0.5\n1 1 1 0.5\n",
    ] {
        assert!(matches!(bad("a.pts", text), InputError::Columns { .. }), "{text}");
        let stated = ReadOptions { dimension: Some(4), ..PLAIN };
        assert_eq!(good_with("a.pts", text, &stated).points.dimension(), 4, "{text}");
    }
    // Intensity and colours. The second line is a point and not the comment of a chemical file.
    let scan = "3\n1 2 3 9 255 0 0\n4 5 6 9 255 0 0\n7 8 9 9 255 0 0\n";
    assert_eq!(space(&good("a.pts", scan)), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]);
    assert!(matches!(bad("a.pts", "3\n1 2 3\n4 5 6\n"), InputError::Truncated { expected: 3, found: 2, .. }));
    assert_eq!(bad("a.pts", "1\n1 2 3\n4 5 6\n").line(), Some(3));
    assert!(matches!(bad("a.xyz", "7\n"), InputError::UnsupportedDimension { found: 1, .. }));
}

#[test]
fn tables_are_recognised_by_content() {
    for name in ["a.dat", "a.pts", "a.asc", "points", "a.DAT", "fd/63"] {
        assert_eq!(good(name, "# c\n1 2\n3 4\n").points.len(), 2, "{name}");
        assert_eq!(good(name, "x,y\n1,2\n").points.len(), 1, "{name}");
        assert_eq!(good(name, npy_f8()).points.len(), 4, "{name}");
        for other in [b"words and words\n".as_slice(), b"\x7fELF\x01\x02", b"1 2\x00 3 4\n"] {
            let error = bad(name, other);
            assert!(matches!(error, InputError::UnknownFormat { .. }) && !error.is_usage(), "{error}");
        }
    }
    for (name, advice) in [
        ("a.vti", "write .vtu"),
        ("a.pcd", ".ply"),
        ("a.gpx", "geographic information system: export its points as .csv"),
        ("a.bz2", "bunzip2"),
        ("a.cvs", "rename it if it is a .csv file"),
        ("a.zzz", "use one of .node"),
    ] {
        let error = bad(name, "1 2 3\n");
        assert!(error.is_usage(), "{error}");
        let message = report(&error);
        assert!(message.contains(advice) && message.contains("--input-format"), "{message}");
    }
    let forced = ReadOptions { format: Some(crate::format::Format::Xyz), ..PLAIN };
    assert_eq!(good_with("a.zzz", "1 2 3\n", &forced).points.len(), 1);
}

#[test]
fn node_files_are_recognised_by_content() {
    // Without recognition, the header would be a point and the ids its coordinates.
    let plane_rows = "4 2 0 0\n1 0.5 0\n2 1 0\n3 0 1\n4 1 1.5\n";
    let space_rows = "# points\n3 3 1 1\n\n0 0 0 0 9 1\n1 1 0 0 9 1 # c\n2 0 1.5 0 9 1\n";
    let four_columns = "2 3 0 0\n1 0 0 0\n2 1 2 3\n";
    let short = "2 3\n1 0 0 0.5\n2 1 2 3\n";
    for name in ["a.dat", "a.pts", "a.asc", "points", "-", "a.zzz"] {
        let file = parse(name, plane_rows, &PLAIN).unwrap();
        assert_eq!(plane(&file), [[0.5, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.5]], "{name}");
        assert_eq!(file.first_id, 1);
        let file = parse(name, space_rows, &PLAIN).unwrap();
        assert_eq!(space(&file), [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0]], "{name}");
        assert_eq!(file.first_id, 0);
        assert_eq!(space(&parse(name, four_columns, &PLAIN).unwrap()), [[0.0; 3], [1.0, 2.0, 3.0]]);
        assert_eq!(space(&parse(name, short, &PLAIN).unwrap()), [[0.0, 0.0, 0.5], [1.0, 2.0, 3.0]]);
        // A file that ends early is incomplete and not a table.
        let error = parse(name, "300 3 0 0\n1 0 0 0\n2 1 2 3\n", &PLAIN).unwrap_err();
        assert!(matches!(error, InputError::Truncated { expected: 300, found: 2, .. }), "{error}");
    }
    for table in ["4 2 0\n1 0.5 0\n3 1 0\n", "4 2 0\n2 0.5 0\n3 1 0\n", "4 2 1\n1 0.5 0\n2 1 0\n", "1 2 3\n"]
    {
        assert_eq!(space(&good("a.dat", table))[0][1], 2.0, "{table}");
    }
}

#[test]
fn more_than_three_unnamed_columns_need_a_choice() {
    for name in ["a.csv", "a.xyz", "a.txt", "a.dat", "-"] {
        let error = parse(name, "7,0.5,1,2\n8,4,5,6\n", &PLAIN).unwrap_err();
        assert!(matches!(error, InputError::Columns { .. }) && error.line() == Some(1), "{error}");
        let message = report(&error);
        assert!(message.contains("4 columns of numbers") && !message.contains("such as"), "{message}");
    }
    let text = "7 0.5 1 2\n8 4 5 6\n";
    assert_eq!(
        space(&good_with("a.txt", text, &columns(&["2", "3", "4"]))),
        [[0.5, 1.0, 2.0], [4.0, 5.0, 6.0]]
    );
    let file = good_with("a.txt", text, &THREE);
    assert_eq!(space(&file), [[7.0, 0.5, 1.0], [8.0, 4.0, 5.0]]);
    assert_eq!(file.notes, ["columns after the first 3 are ignored"]);
    assert_eq!(plane(&good_with("a.txt", text, &TWO)), [[7.0, 0.5], [8.0, 4.0]]);
    // Text is not a coordinate.
    assert_eq!(space(&good("a.txt", "7 0.5 1 label\n8 4 5 6\n")), [[7.0, 0.5, 1.0], [8.0, 4.0, 5.0]]);
    refused("1 2 3 4\n", &ReadOptions { keep_columns: true, ..PLAIN });
}

#[test]
fn ignored_columns_are_listed_or_counted() {
    for (text, end) in [
        ("x y\n1 2 3\n4 5 6\n", "coordinates are x, y; 1 unnamed column is ignored"),
        ("x,y,,\n1,2,3,4\n", "coordinates are x, y; 2 unnamed columns are ignored"),
        ("a,x,y,b\n1,2,3,4\n", "coordinates are x, y; columns a, b are ignored"),
        ("a,x,y,\n1,2,3,4\n", "coordinates are x, y; column a and 1 unnamed column are ignored"),
    ] {
        let notes = good("a.txt", text).notes;
        assert!(notes.len() == 1 && notes[0].ends_with(end), "{notes:?}");
    }
    assert_eq!(bad("a.csv", "x,y\n1,2\n3,4,5\n").line(), Some(3));
    for text in
        ["x,y,z\n1,2,3\n1,2,3,,5\n", "\n1;2;3\n1;2;3;;7\n", "\n1,2\n1,2,,,7\n", "\n1,2,3\n1,2,3,\"\",7\n"]
    {
        assert_eq!(bad("a.csv", text).line(), Some(3), "{text}");
    }
    assert_eq!(space(&good("a.csv", "x,y,z\n1,2,3\n1,2,3,,\n")), [[1.0, 2.0, 3.0]; 2]);
    let keep = ReadOptions { keep_columns: true, ..PLAIN };
    let file = good_with("a.csv", "x,y\n1,2,3\n", &keep);
    assert_eq!((file.columns[0].name.as_str(), &file.columns[0].values[..]), ("column_1", &[1.0][..]));
    assert_eq!(plane(&file), [[2.0, 3.0]]);
}
