//! `septet mesh`.

use std::path::PathBuf;

use clap::Args;
use septet::geometry::range::scale;
use septet::io::read::{AnyInput, DomainFile, read_domain};
use septet::meshing::check;
use septet::meshing::defect::Defect;
use septet::meshing::domain::{Domain, Feature};
use septet::meshing::facet::Triangulate;
use septet::meshing::input::Input;

use super::errors::{Code, Failure};
use super::progress::Talk;

/// Options of `septet mesh`.
#[derive(Debug, Args)]
#[command(after_help = "\
A piecewise linear complex (.poly, .smesh) may have internal and dangling pieces; a surface (.stl .off .ply .obj)
must be closed. Exit code 3 and the list of all defects if the domain has any.

Examples:
  septet mesh part.poly --check
  septet mesh scan.stl --check")]
pub struct MeshArgs {
    /// The domain: .poly .smesh .stl .off .ply .obj, each also .gz
    domain: PathBuf,
    /// Check the domain, and do no more
    #[arg(long, required = true)]
    check: bool,
}

/// Small angles and pieces left out that are listed.
const SHOWN: usize = 20;

/// Reads and checks.
pub fn run(args: &MeshArgs, talk: &Talk) -> Result<(), Failure> {
    let file = read_domain(&args.domain, &mut |read, total| talk.stage("reading", read, total))?;
    talk.check();
    talk.clear();
    for note in &file.notes {
        talk.note(format!("note: {note}"));
    }
    match &file.input {
        AnyInput::Plane(input) => checked(args, &file, input, talk),
        AnyInput::Space(input) => checked(args, &file, input, talk),
    }
}

fn checked<P: Triangulate>(
    args: &MeshArgs,
    file: &DomainFile,
    input: &Input<P>,
    talk: &Talk,
) -> Result<(), Failure> {
    match check(input) {
        Ok(domain) => {
            summary(args, file, &domain, talk);
            Ok(())
        }
        Err(defects) => {
            for defect in &defects {
                talk.fault(format!("{}: {}", defect.kind(), defect.in_file(file.first_id)));
            }
            Err(refusal(args, &defects))
        }
    }
}

fn refusal(args: &MeshArgs, defects: &[Defect]) -> Failure {
    let count = defects.len();
    let what = if count == 1 { "defect" } else { "defects" };
    Failure::new(Code::Input, format!("{} has {count} {what}", args.domain.display()))
        .help("mend the places listed above; ids are those of the file, facets in its order")
}

fn summary<P: Triangulate>(args: &MeshArgs, file: &DomainFile, domain: &Domain<P>, talk: &Talk) {
    let inside = domain.components.iter().filter(|c| c.inside).count();
    let regions = domain.components.iter().filter(|c| c.region.is_some()).count();
    // Scaled once for each dimension, so that the factor stays a power of two in range.
    let mut measure = P::splat(domain.measure());
    for _ in 0..P::DIM {
        measure = scale(measure, -domain.simplices.exponent);
    }
    talk.note(format!(
        "septet: {} is a domain: {} points, {} corners, {} segments, {} facets, {inside} components, {regions} \
         regions, {} {}",
        args.domain.display(),
        domain.points().len(),
        domain.corners.len(),
        domain.segments.len(),
        domain.facets.len(),
        if P::DIM == 2 { "area" } else { "volume" },
        measure.coord(0),
    ));
    for piece in domain.left_out.iter().take(SHOWN) {
        talk.note(format!("note: {} lies outside the domain and is left out", piece.in_file(file.first_id)));
    }
    if domain.left_out.len() > SHOWN {
        talk.note(format!("note: and {} more pieces that are left out", domain.left_out.len() - SHOWN));
    }
    let small = domain.small_angles(90.0);
    for angle in small.iter().take(SHOWN) {
        let name = |feature| named(domain, feature, file.first_id);
        let at = domain.simplices.place(angle.at);
        let [a, b] = angle.features.map(name);
        talk.note(format!("{a} and {b}, {:.3} degrees, at {at}", angle.degrees()));
    }
    if small.len() > SHOWN {
        talk.note(format!("and {} more angles below 90 degrees", small.len() - SHOWN));
    }
}

/// A feature by the ids of the file.
fn named<P: Triangulate>(domain: &Domain<P>, feature: Feature, first_id: u64) -> String {
    let id = |v: u32| u64::from(v) + first_id;
    match feature {
        Feature::Corner(c) => format!("point {}", id(domain.corners[c as usize])),
        Feature::Segment(s) => {
            let [a, b] = domain.segments[s as usize].ends();
            format!("segment {}-{}", id(a), id(b))
        }
        Feature::Facet(f) => format!("facet {}", id(domain.facets[f as usize].of[0])),
    }
}
