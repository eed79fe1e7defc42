//! The separator theorem for the faces of a periodic box: images of `n` evenly spread points.
//!
//! **Statement.** The faces of a box are `d` more separators. Let the balls of `n` points have ply `k`, in a box of volume `V`
//! and lengths `L_a`. By Hoelder's inequality, the sum of their radii is at most `n^(1-1/d) (sum r_i^d)^(1/d)`. So a face at a
//! random place crosses `O(k^(1/d) n^(1-1/d) V^(1/d) / L_a)` balls: the order of Theorem 2.1 for boxes of bounded aspect.
//!
//! **Work.** One triangulation of the points and their images for each figure.
//!
//! **Departures.** The statement is not in the paper. It is the theorem for surfaces that the user gives.

use septet_core::generate::Kind;
use septet_core::spec::{Periodic, Workers};
use septet_core::{Spec, triangulate};

use super::lab::Lab;
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// The ratios of the first length of the box to the others.
const ASPECTS: [u32; 4] = [1, 2, 4, 8];

/// The width of the cover beyond the box, in distances of evenly spread points, in the plane and in space.
const WIDTH: [f64; 2] = [5.0, 3.5];

/// The largest excess over the expected number of images. The count has the deviation of a Poisson variable, at most 2 % here.
const EXCESS: f64 = 1.1;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "torus",
    role: Role::Illustration,
    statistics: None,
    source: "Theorem 2.1, for the faces of a periodic box",
    statement: "a separator of n evenly spread balls crosses O(n^(1-1/d)) of them",
    reading: Reading::AsRead {
        instead: "a periodic box adds O(n^(1-1/d) V^(1/d) / L_a) images for each axis a",
        because: "the faces of the box are separators that the user gives, and each ball that they cross needs an image",
    },
    experiment: "Images of uniform points in boxes with a first length of 1, 2, 4 and 8 times the others, over n ((1 + 2 w / L_1) ... \
                 (1 + 2 w / L_d) - 1), where w is 5 (plane) or 3.5 (space) distances of evenly spread points; and, per point of \
                 n^(1-1/d) V^(1/d) sum 1 / L_a, their growth from the smallest set to the largest",
    bound: "1.1, because the numbers are binomial, and a second pass would double w; growth of at most 1, because the edges and \
            corners of the box count less in a larger set",
    check: torus,
}];

fn torus(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    let sizes = [1 << 10, if lab.brief() { 1 << 13 } else { lab.size(1 << 15, 1 << 20) }];
    for d in [2, 3] {
        for aspect in ASPECTS {
            let mut quotients = Vec::new();
            for n in sizes {
                let sample = Sample::new(Kind::Uniform, n, d);
                let lengths: Vec<f64> =
                    (0..d).map(|a| if a == 0 { f64::from(aspect) } else { 1.0 }).collect();
                let images = images(lab, sample, &lengths)? as f64;
                let spacing = (f64::from(aspect) / n as f64).powf(1.0 / d as f64);
                let width = WIDTH[d - 2] * spacing;
                let cover: f64 = lengths.iter().map(|length| 1.0 + 2.0 * width / length).product();
                let expected = n as f64 * (cover - 1.0);
                let on = format!("{} in a box of aspect {aspect}", sample.name());
                let what = "images over their expected number";
                figures.push(Figure::at_most(what, on, lab.seed(), images / expected, EXCESS));
                let faces: f64 = lengths.iter().map(|length| 1.0 / length).sum();
                quotients.push(images / (n as f64 * spacing * faces));
            }
            let on = format!("uniform {d}D n={}..{} in a box of aspect {aspect}", sizes[0], sizes[1]);
            let what = "growth of images over n^(1-1/d) V^(1/d) sum 1/L_a";
            figures.push(Figure::at_most(what, on, lab.seed(), quotients[1] / quotients[0], 1.0));
            if lab.has_detected(&figures) {
                return Ok(figures);
            }
        }
    }
    Ok(figures)
}

/// Returns the number of images in a box with these lengths.
fn images(lab: &mut Lab, sample: Sample, lengths: &[f64]) -> Result<u64, ClaimError> {
    let points = lab.points(sample, lab.seed())?;
    let mut spec = Spec::default();
    spec.input.periodic = Some(Periodic::of_lengths(lengths));
    spec.machine.workers = Workers::Count(1);
    spec.machine.threads = Some(lab.options.threads);
    spec.control.cancel.clone_from(&lab.options.cancel);
    let run = if sample.d == 2 {
        let scaled: Vec<[f64; 2]> = points.iter().map(|x| [0, 1].map(|a| x[a] * lengths[a])).collect();
        triangulate(&scaled, &spec)?
    } else {
        let scaled: Vec<[f64; 3]> = points.iter().map(|x| [0, 1, 2].map(|a| x[a] * lengths[a])).collect();
        triangulate(&scaled, &spec)?
    };
    Ok(run.kept.periodic.map_or(0, |part| part.images))
}
