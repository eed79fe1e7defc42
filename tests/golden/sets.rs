//! Point sets: six kinds in the plane and in space.

use crate::calls::{Cloud, Draw};

/// The kinds by name.
pub const KINDS: [&str; 6] = ["uniform", "clusters", "grid", "duplicates", "flat", "sphere"];

/// About `n` points of a kind.
pub fn cloud(kind: &str, dimension: usize, n: usize) -> Cloud {
    let mut draw = Draw::new(n as u64 * 31 + dimension as u64);
    let coordinates = match kind {
        "uniform" => (0..n * dimension).map(|_| draw.unit()).collect(),
        "clusters" => clusters(dimension, n, &mut draw),
        "grid" => grid(dimension, side(dimension, n)),
        "duplicates" => duplicates(dimension, n, &mut draw),
        "flat" => flat(dimension, n, &mut draw),
        "sphere" => sphere(dimension, n, &mut draw),
        _ => panic!("no kind {kind}"),
    };
    Cloud { dimension, coordinates }
}

/// All points in one plane of space, or on one line of the plane: there are no cells.
pub fn sunken(dimension: usize, n: usize) -> Cloud {
    let mut cloud = cloud("uniform", dimension, n);
    for point in cloud.coordinates.chunks_exact_mut(dimension) {
        point[dimension - 1] = 0.25;
    }
    cloud
}

/// The side of a grid of about `n` points.
fn side(dimension: usize, n: usize) -> usize {
    (n as f64).powf(1.0 / dimension as f64).round() as usize
}

fn grid(dimension: usize, side: usize) -> Vec<f64> {
    let place = |i: usize| (0..dimension).map(move |axis| (i / side.pow(axis as u32) % side) as f64);
    (0..side.pow(dimension as u32)).flat_map(place).collect()
}

/// A third of the points in a clump a thousandth as wide, a third in one a twentieth as wide.
fn clusters(dimension: usize, n: usize, draw: &mut Draw) -> Vec<f64> {
    let mut all = Vec::new();
    for i in 0..n {
        let (width, middle) = [(1e-3, 0.5), (1.0, 0.0), (0.05, 0.75)][i % 3];
        all.extend((0..dimension).map(|_| draw.unit() * width + middle));
    }
    all
}

/// A small grid many times over, in random order, with as many random points.
fn duplicates(dimension: usize, n: usize, draw: &mut Draw) -> Vec<f64> {
    let small = grid(dimension, side(dimension, n / 4));
    let mut points: Vec<Vec<f64>> = small.chunks_exact(dimension).map(<[f64]>::to_vec).collect();
    points.extend(points.clone());
    while points.len() < n {
        points.push((0..dimension).map(|_| draw.unit() * 4.0).collect());
    }
    draw.shuffle(&mut points);
    points.concat()
}

/// Three layers, each exactly flat.
fn flat(dimension: usize, n: usize, draw: &mut Draw) -> Vec<f64> {
    let mut all = Vec::new();
    for i in 0..n {
        all.extend((1..dimension).map(|_| draw.unit()));
        all.push([0.0, 0.125, 0.5][i % 3]);
    }
    all
}

/// On a sphere or circle, up to rounding.
fn sphere(dimension: usize, n: usize, draw: &mut Draw) -> Vec<f64> {
    let mut all = Vec::new();
    while all.len() < n * dimension {
        let point: Vec<f64> = (0..dimension).map(|_| 2.0 * draw.unit() - 1.0).collect();
        let radius = point.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (0.1..1.0).contains(&radius) {
            all.extend(point.iter().map(|x| x / radius));
        }
    }
    all
}
