//! Columns of numbers and `.node`.

use super::*;
use crate::read::Place;

#[test]
fn separators_comments_and_line_ends() {
    let want = vec![[1.0, 2.0, 3.0], [-4.0, 0.5, 6e-3]];
    for text in [
        "1 2 3\n-4 .5 6e-3\n",
        "1 2 3\r\n-4 .5 6e-3",
        "1 2 3\r-4 .5 6e-3\r",
        "\u{feff}1 2 3\n-4 .5 6e-3",
        "1,2,3\n-4,.5,6e-3\n",
        "1, 2 ,3\n-4,.5,6e-3,\n",
        "1;2;3\n-4; .5;6e-3\n",
        "1\t2\t3\n\n  -4\t.5\t6e-3\n",
        "# c\n% c\n// c\n\n1 2 3 # end\n-4 .5 6e-3 // end\n",
        "1,2,3,# c\n-4 .5 6e-3 % 9\n",
    ] {
        assert_eq!(space(&good("a.xyz", text)), want, "{text:?}");
    }
    assert_eq!(plane(&good("a.csv", "1,2\n3,4,\n")), [[1.0, 2.0], [3.0, 4.0]]);
}

#[test]
fn nothing_is_an_empty_set() {
    for text in ["", "\n\n", "# only a comment\n", "0\n"] {
        let file = good("a.txt", text);
        assert_eq!((file.points.len(), file.points.dimension()), (0, 3), "{text:?}");
    }
    assert_eq!(good_with("a.txt", "", &TWO).points.dimension(), 2);
}

#[test]
fn a_header_row_and_further_columns_are_noted() {
    let file = good("a.csv", "\"x\",y,z,name\n1,2,3,here be text\n4,5,6,\n7,8,9\n");
    assert_eq!(space(&file).len(), 3);
    assert!(noted(
        &file.notes,
        "line 1 is taken as a header row: coordinates are x, y, z; column name is ignored"
    ));
    assert_eq!(file.notes.len(), 1);
    let file = good("a.csv", "1,2,3,here be text\n4,5,6,\n7,8,9\n");
    assert!(noted(&file.notes, "columns after the first 3") && file.notes.len() == 1);
    assert_eq!(bad("a.csv", "x,y\na,b\n1,2\n").line(), Some(2));
}

#[test]
fn the_dimension_can_be_chosen() {
    assert_eq!(
        plane(&good_with("a.txt", "1,2,3\n4,5\n6,7,label\n", &TWO)),
        [[1.0, 2.0], [4.0, 5.0], [6.0, 7.0]]
    );
    assert!(matches!(
        bad_with("a.txt", "1 2\n", &THREE),
        InputError::MixedDimension { expected: 3, found: 2, .. }
    ));
    let seven = ReadOptions { dimension: Some(7), ..PLAIN };
    assert!(matches!(bad_with("a.txt", "1 2\n", &THREE), InputError::MixedDimension { .. }));
    let mut quiet = |_, _| ();
    let refused = crate::read::read_from(&b"1 2"[..], Path::new("a.txt"), None, &seven, &mut quiet);
    assert!(matches!(refused, Err(InputError::UnsupportedDimension { found: 7, .. })));
}

#[test]
fn mixed_rows_are_refused() {
    for (text, line) in [("1 2 3\n4 5\n", 2), ("1 2\n\n4 5 6\n", 3), ("1,2,3\n4 5\n", 2), ("1 2\n3\n", 2)] {
        let error = bad("a.xyz", text);
        assert!(matches!(error, InputError::MixedDimension { .. }), "{error}");
        assert_eq!(error.line(), Some(line), "{text:?}");
    }
    assert!(matches!(bad("a.xyz", "1\n2\n"), InputError::UnsupportedDimension { found: 1, .. }));
}

#[test]
fn decimal_commas_are_refused() {
    for text in [
        "1,5 2,5 3,5\n",
        "1,5\t2,5\t3,5\n",
        "1,5, 2,5, 3,5\n",
        "1.5;2.5\n1,5;2,5\n",
        "x y z\n1,5 2,5 3,5\n",
        "1,5 2,5\n",
        "0.5 2,5\n",
    ] {
        let error = bad("a.txt", text);
        assert!(matches!(error, InputError::Syntax { .. }), "{error}");
        assert!(error.to_string().contains("decimal"), "{error}");
    }
}

#[test]
fn decimal_commas_are_read_between_semicolons() {
    let file = good("a.csv", "id;x;y\n7;1,5;2,25\n8;-3;1e-2\n");
    assert_eq!(plane(&file), [[1.5, 2.25], [-3.0, 0.01]]);
    assert!(noted(&file.notes, "decimal commas"), "{:?}", file.notes);
    assert_eq!(space(&good("a.csv", "1,5;2,5;3,5\n")), [[1.5, 2.5, 3.5]]);
    assert_eq!(bad("a.csv", "1,5;2,5\n1.5;2,5\n").line(), Some(1));
}

#[test]
fn rows_have_the_width_of_the_table() {
    for (text, line) in [
        ("x,y,z\n1,2,3\n1,2,3,4\n", 3),
        ("x,y\n0,5118,0,9505\n", 2),
        ("x y z q\n1 2 3 4\n1 3 4\n", 3),
        ("1 2 3 A\n4 5 6 A 7\n", 2),
        ("1 2 3 9\n4 6 9\n", 2),
        ("x;y\n1;2\n1;2;3\n", 3),
    ] {
        let options = if text.starts_with('1') { THREE } else { PLAIN };
        let error = bad_with("a.csv", text, &options);
        assert!(error.line() == Some(line) && error.to_string().contains("fields"), "{error}");
    }
    assert_eq!(plane(&good("a.csv", "x,y,note\n1,2\n3,4,\n")).len(), 2);
}

#[test]
fn names_of_rows_shift_the_header() {
    let want = [[0.5, 1.0, 2.0], [3.0, 4.0, 5.0]];
    for text in [
        "\"x\" \"y\" \"z\"\n\"1\" 0.5 1 2\n\"2\" 3 4 5\n",
        "x y z\n1 0.5 1 2\n2 3 4 5\n",
        "\tx\ty\tz\n0\t0.5\t1\t2\n1\t3\t4\t5\n",
        "x,y,z\nA,0.5,1,2\nB,3,4,5\n",
        "# z y x\n2 1 0.5\n5 4 3\n",
        "#7 z y x\n#8 2 1 0.5\n#9 5 4 3\n",
    ] {
        let text = text.replace("#7 z", "id z");
        assert_eq!(space(&good("a.txt", &text)), want, "{text}");
    }
    assert_eq!(bad("a.txt", "x y z\n2 0.5 1 2\n1 3 4 5\n").line(), Some(2));
}

#[test]
fn tabs_alone_separate_fields() {
    let text = "id\tname\tx\ty\n0\t\t0.5\t1\n1\tTree 7\t2\t3\n";
    assert_eq!(plane(&good("a.txt", text)), [[0.5, 1.0], [2.0, 3.0]]);
    assert_eq!(plane(&good("a.txt", "1 \t 2\n3\t4\n")), [[1.0, 2.0], [3.0, 4.0]]);
    // Blanks and tabs.
    assert_eq!(space(&good("a.txt", "1  2\t3\n4\t5  6\n")), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(bad("a.txt", "0.5\t\t1\t2\n").line(), Some(1));
}

#[test]
fn a_first_column_that_counts_is_an_id() {
    for (text, columns) in [
        ("1,0.5,2\n2,3,4\n3,5,6\n", "2,3"),
        ("0 0.5 2 7\n1 3 4 7\n2 5 6 7\n", "2,3,4"),
        ("3\n1 0.5 2 7\n2 3 4 7\n3 5 6 7\n", "2,3,4"),
        ("0.000000e+00 0.5 2\n1.000000e+00 3 4\n2.000000e+00 5 6\n", "2,3"),
        ("1,0;0,5;2\n2,0;3;4\n3,0;5;6\n", "2,3"),
    ] {
        let error = bad("a.txt", text);
        assert!(
            error.is_usage() && report(&error).ends_with(&format!("such as --columns {columns}")),
            "{error}"
        );
    }
    let error = bad_with("a.txt", "1 0.5 2 7\n2 3 4 7\n3 5 6 7\n", &THREE);
    assert!(error.to_string().contains("counts the rows from 1"), "{error}");
    for text in [
        "0 0 0\n1 1 1\n2 4 8\n",
        "1 0.5\n2 3\n3 5\n",
        "0.0 0.5\n1.0 3\n2.0 5\n",
        "1 0.5 2\n2 3 4\n1 5 6\n",
        "1 0.5 2\n2 3 4\n",
    ] {
        good("a.txt", text);
    }
}

#[test]
fn counts_come_first() {
    let rows = "0.5 1\n2 3\n4 5\n";
    for head in ["3 2\n", "2\n3\n", "3\n2\n", "2 rbox 3 D2\n3\n", "3\n", "# c\n\n3 2 0\n"] {
        let text = format!("{head}{rows}");
        assert_eq!(plane(&good("a.txt", &text)).len(), 3, "{text}");
    }
    assert_eq!(plane(&good("a.txt", format!("4 2\n{rows}"))).len(), 4);
    assert!(matches!(bad("a.txt", "4 3\n0.5 1 2\n3 4 5\n"), InputError::Truncated { expected: 4, .. }));
    assert!(matches!(bad("a.txt", format!("2\n4\n{rows}")), InputError::Truncated { expected: 4, .. }));
}

#[test]
fn lines_that_are_no_rows_are_counted() {
    let file = good("a.csv", "# a\n\n# b\nid,x,y\n1,2,3\n# c\n\n2,3,4\n");
    assert_eq!((file.reading.rows, file.reading.lines.counts()), (2, [1, 0, 3, 2]));
    assert_eq!((file.reading.columns.join(" "), file.reading.ignored.join(" ")), ("x y".into(), "id".into()));
    let file = good("a.pts", "// z y x\n2\n1 2 3\n4 5 6\n");
    assert_eq!((file.reading.rows, file.reading.lines.counts()), (2, [1, 1, 0, 0]));
    assert_eq!(good("a.off", "OFF\n1 0 0\n0 0 0\n").reading.rows, 1);
}

#[test]
fn a_bad_number_is_pointed_at() {
    let error = bad("a.txt", "1 2 3\n4  5x 6\n");
    let InputError::Syntax { line: 2, column: Some(4), text, .. } = &error else { panic!("{error}") };
    assert_eq!(&**text, "5x");
    assert_eq!(bad("a.csv", "1,,3\n").column(), Some(3));
    assert!(matches!(bad("a.txt", "1.0D0 2 3\n"), InputError::Syntax { line: 1, .. }));
    let long = bad("a.txt", format!("1 2 3\n1 2 {}\n", "é\u{1b}".repeat(1000))).to_string();
    assert!(long.len() < 400 && !long.contains('\u{1b}'));
    assert!(matches!(bad("a.txt", b"\xff\xfe1\x00"), InputError::Unsupported { .. }));
}

#[test]
fn invalid_points_fail_or_are_dropped() {
    let text = "0 0 0\nnan 1 1\n1 1 1\n2 inf 2\n3 3 3\n4 4 x\n5 5 1e999\n6,6,\n7 7 7\n";
    let error = bad("a.xyz", text);
    assert!(matches!(error, InputError::NotFinite { place: Place::Line(2), index: 1, .. }), "{error}");
    let file = good_with("a.xyz", text, &SKIP);
    assert_eq!(file.skipped, 5);
    assert_eq!(space(&file).iter().map(|p| p[0]).collect::<Vec<_>>(), [0.0, 1.0, 3.0, 7.0]);
    assert_eq!(file.source_index, Some(vec![0, 2, 4, 8]));
    assert!(matches!(bad_with("a.xyz", "1 2 3\n1 2\n", &SKIP), InputError::MixedDimension { .. }));
    assert_eq!(good_with("a.xyz", "1 2 3\n", &SKIP).source_index, None);
}

#[test]
fn numbers_are_exact_and_zeros_positive() {
    let file = good("a.txt", "0.1 1e-320 -0.0\n1.7976931348623157e308 -0 9007199254740993\n");
    let points = space(&file);
    assert_eq!(points[0], [0.1, 1e-320, 0.0]);
    assert_eq!(points[1], [f64::MAX, 0.0, 9_007_199_254_740_992.0]);
    assert!(points[0][2].is_sign_positive() && points[1][1].is_sign_positive());
}

#[test]
fn chemical_files_are_recognised() {
    let file = good("a.xyz", "2\nwater # 1\nO 0 0 0\nH 1.5 0 0 extra\n\n");
    assert_eq!(space(&file), [[0.0, 0.0, 0.0], [1.5, 0.0, 0.0]]);
    assert!(noted(&file.notes, "chemical"));
    assert_eq!(space(&good("a.xyz", "1\r\n\r\n8 0 0 1\r\n")), [[0.0, 0.0, 1.0]]);
    assert!(matches!(
        bad("a.xyz", "3\n\nO 0 0 0\nH 1 0 0\n"),
        InputError::Truncated { expected: 3, found: 2, .. }
    ));
    assert!(matches!(bad("a.xyz", "1\n\nO 0 0 0\nH 1 0 0\n"), InputError::Count { expected: 1, .. }));
    assert!(matches!(bad("a.xyz", "100000000000000\n\nO 0 0 0\n"), InputError::Truncated { .. }));
    assert_eq!(bad("a.xyz", "1\n\nO 0 nan 0\n").line(), Some(3));
}

#[test]
fn node_files_of_either_base() {
    let one = good("a.node", "# c\n2 3 1 1\n\n 1 0 0 0 5 1 # c\n2 1 2 3 5 1\n");
    assert_eq!(space(&one), [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]);
    assert_eq!(one.first_id, 1);
    assert!(noted(&one.notes, "1 attribute and 1 boundary marker per point are ignored"));
    let zero = good("a.node", "2 2\r\n0 0 0\r\n1 1 2\r\n");
    assert_eq!((plane(&zero), zero.first_id), (vec![[0.0, 0.0], [1.0, 2.0]], 0));
    assert_eq!(good("a.node", "0 3 0 0\n").points.len(), 0);
    assert_eq!(plane(&good_with("a.node", "1 3\n1 4 5 6\n", &TWO)), [[4.0, 5.0]]);
    let dropped = good_with("a.node", "3 2\n1 0 0\n2 nan 0\n3 1 1\n", &SKIP);
    assert_eq!((dropped.source_index, dropped.first_id), (Some(vec![0, 2]), 1));
}

#[test]
fn damaged_node_files() {
    assert!(matches!(bad("a.node", ""), InputError::Truncated { .. }));
    assert!(matches!(bad("a.node", "x 3\n"), InputError::Syntax { line: 1, .. }));
    assert!(matches!(bad("a.node", "-1 3\n"), InputError::Syntax { line: 1, .. }));
    assert!(matches!(bad("a.node", "1 4\n1 0 0 0 0\n"), InputError::UnsupportedDimension { found: 4, .. }));
    assert!(matches!(bad("a.node", "2 2\n1 0 0\n"), InputError::Truncated { expected: 2, found: 1, .. }));
    assert_eq!(bad("a.node", "1 2\n1 0 0\n2 0 0\n").line(), Some(3));
    assert!(matches!(bad("a.node", "2 2\n1 0 0\n3 0 0\n"), InputError::Syntax { line: 3, .. }));
    assert!(matches!(bad("a.node", "2 2\n2 0 0\n3 0 0\n"), InputError::Syntax { line: 2, .. }));
    assert!(matches!(
        bad("a.node", "1 3\n1 0 0\n"),
        InputError::MixedDimension { expected: 3, found: 2, .. }
    ));
    assert!(matches!(bad("a.node", "1 3\n1 0,5 0 0\n"), InputError::Syntax { line: 2, column: Some(3), .. }));
    assert!(matches!(bad_with("a.node", "1 2\n1 0 0\n", &THREE), InputError::MixedDimension { .. }));
    for count in ["100000000000000", "9223372036854775807"] {
        let error = bad("a.node", format!("{count} 3\n1 0 0 0\n"));
        assert!(matches!(error, InputError::Truncated { found: 1, .. }), "{error}");
    }
}
