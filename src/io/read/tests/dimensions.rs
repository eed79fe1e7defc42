//! Points of dimensions 4 to 6.

use super::*;

/// An array of these numbers in rows of `columns`.
fn array(columns: usize, numbers: &[f64]) -> Vec<u8> {
    let shape = format!("({}, {columns})", numbers.len() / columns);
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    npy(&header, &bytes)
}

fn in_dimension(dimension: usize) -> ReadOptions {
    ReadOptions { dimension: Some(dimension), ..PLAIN }
}

fn columns(names: &[&str]) -> ReadOptions {
    ReadOptions { columns: Some(names.iter().map(|&name| name.to_owned()).collect()), ..PLAIN }
}

#[test]
fn arrays_have_the_dimension_of_their_columns() {
    for dimension in 4..=6 {
        let numbers: Vec<f64> = (0..3 * dimension).map(|i| (i * i) as f64).collect();
        for options in [PLAIN, in_dimension(dimension)] {
            let file = good_with("a.npy", array(dimension, &numbers), &options);
            assert_eq!((file.points.dimension(), file.points.coordinates()), (dimension, &numbers[..]));
        }
        for other in (2..=6).filter(|&other| other != dimension) {
            bad_with("a.npy", array(dimension, &numbers), &in_dimension(other));
        }
    }
    let negative = good("a.npy", array(4, &[-0.0, 1.0, 2.0, 3.0]));
    assert_eq!(negative.points.coordinates()[0].to_bits(), 0);
    let skip = good_with("a.npy", array(4, &[1.0, 2.0, f64::NAN, 4.0, 5.0, 6.0, 7.0, 8.0]), &SKIP);
    assert_eq!((skip.points.len(), skip.source_index), (1, Some(vec![1])));
    for columns in [1, 7, 8] {
        let message = report(&bad("a.npy", array(columns, &vec![1.0; 5 * columns])));
        assert!(message.contains("supported: 2 to 6"), "{message}");
    }
}

#[test]
fn homogeneous_coordinates_are_refused() {
    let numbers = [0.0, 1.0, 2.0, 1.0, 3.0, 4.0, 5.0, 1.0];
    let error = bad("a.npy", array(4, &numbers));
    let message = report(&error);
    assert!(message.contains("shape (2, 4)") && message.contains("homogeneous coordinates?"), "{message}");
    assert!(message.contains("--dimension 4"), "{message}");
    let stated = good_with("a.npy", array(4, &numbers), &in_dimension(4));
    assert_eq!(stated.points.coordinates(), numbers);
    // A single row shows nothing, and three columns are those of space.
    assert_eq!(good("a.npy", array(4, &numbers[..4])).points.dimension(), 4);
    assert_eq!(good("a.npy", array(3, &[0.0, 1.0, 7.0, 2.0, 3.0, 7.0])).points.dimension(), 3);
}

#[test]
fn tables_need_the_dimension_or_the_columns() {
    let text = "0 1 2 3.5\n4 5 6 7\n8 9 1 2\n";
    let want = [0.0, 1.0, 2.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 1.0, 2.0];
    bad("a.txt", text);
    for options in [in_dimension(4), columns(&["1", "2", "3", "4"])] {
        let file = good_with("a.txt", text, &options);
        assert_eq!((file.points.dimension(), file.points.coordinates()), (4, &want[..]));
    }
    assert!(matches!(bad_with("a.txt", text, &in_dimension(5)), InputError::MixedDimension { found: 4, .. }));
    let named = format!("a,b,c,d\n{}", text.replace(' ', ","));
    bad("a.csv", &named);
    for options in [in_dimension(4), columns(&["a", "b", "c", "d"])] {
        assert_eq!(good_with("a.csv", &named, &options).points.coordinates(), want);
    }
    // No column is dropped silently.
    let message = report(&bad_with("a.csv", &named, &in_dimension(5)));
    assert!(message.contains("4 columns for 5 coordinates"), "{message}");
    let swapped = good_with("a.csv", &named, &columns(&["d", "c", "b", "a"]));
    assert_eq!(swapped.points.coordinates()[..4], [3.5, 2.0, 1.0, 0.0]);
    assert!(report(&bad_with("a.txt", text, &columns(&["1"; 7]))).contains("two to six"));
}

#[test]
fn points_of_higher_dimensions_have_no_weights() {
    let error = bad_with("a.npy", array(5, &[1.0; 10]), &weights::weights("5"));
    assert!(error.to_string().contains("points of dimension 4 have no weights"), "{error}");
}
