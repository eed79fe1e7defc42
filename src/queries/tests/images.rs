use glam::{DVec2, DVec3};

use crate::volumes_in_box;

/// Cells with vertices far from each other have the volumes of the cells that their images form.
#[test]
fn far_vertices_keep_the_volume() {
    let points = [DVec2::new(0.3, 0.25), DVec2::new(1_048_576.7, 0.25), DVec2::new(0.3, 0.75)];
    let expected = (1_048_576.7 - 1_048_576.0 - 0.3) * 0.25;
    for (cell, offsets) in
        [([0, 1, 2], [0, 0, -1 << 20, 0, 0, 0]), ([1, 2, 0], [0, 0, 1 << 20, 0, 1 << 20, 0])]
    {
        let found = volumes_in_box(&points, (&cell, &offsets), &[Some(1.0), Some(1.0)]);
        assert!((found[0] - expected).abs() < 1e-15 * expected, "{found:?} {expected}");
    }
    // The square of a determinant is beyond the range of floats.
    let points = [points[0] * 2f64.powi(-500)];
    let length = Some(2f64.powi(-500));
    let found = volumes_in_box(&points, (&[0; 3], &[0, 0, 1, 0, 0, 1]), &[length, length]);
    assert_eq!(found, [2f64.powi(-1001)]);
}

/// A thin cell needs big integers.
#[test]
fn thin_cells_have_exact_volumes() {
    let height = 2f64.powi(-60);
    let points = [DVec3::ZERO, DVec3::new(0.5, 0.5, height)];
    let offsets = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0];
    let found = volumes_in_box(&points, (&[0, 0, 0, 1], &offsets), &[Some(1.0), Some(1.0), None]);
    assert_eq!(found, [height / 6.0]);
}
