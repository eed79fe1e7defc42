//! A mesh on the page: its figures with their tables, and its summary. A script of the page draws the picture.

mod data;
mod summary;

use serde_json::json;

pub(super) use data::{MeshData, read};
pub(super) use summary::{headline, section};

use septet_core::mesh::run_log::StagePhase;
use septet_lab::report::mesh::StageReport;

use super::bars::{Bar, bars};
use super::histograms::{Drawn, draw, table};
use super::{DataTable, PageFigure, Variant};

/// Draws the figures of a mesh.
pub(super) fn figures(mesh: &MeshData) -> Vec<PageFigure> {
    let mut figures = vec![quality(mesh)];
    figures.extend(stages(&mesh.file.stages));
    figures.extend(phases(&mesh.file.phases));
    figures
}

/// Draws the histograms of the bounded quantities and of cell quality.
fn quality(mesh: &MeshData) -> PageFigure {
    let (q, space) = (&mesh.file.quality, mesh.file.domain.dimension == 3);
    let angle = if space { "dihedral angles" } else { "angles" };
    let mut all = vec![
        ("radius-edge ratios".to_owned(), Drawn::RadiusEdge, &q.radius_edge),
        (angle.to_owned(), Drawn::Angles, &q.angles),
        (format!("smallest {angle}"), Drawn::LeastAngles, &q.least_angles),
        (format!("largest {angle}"), Drawn::LargestAngles, &q.largest_angles),
        ("edges over f".to_owned(), Drawn::Lengths, &q.length_over_size),
    ];
    if let Some(sizes) = &q.size_over_local_size {
        all.push(("f over local feature size".to_owned(), Drawn::Sizes, sizes));
    }
    let bound = mesh.file.parameters.radius_edge;
    let variant = |(name, drawn, histogram): (String, Drawn, _)| {
        let bars = drawn.bars(histogram, bound);
        Variant { name, body: draw(&bars), table: table(&bars) }
    };
    let caption = format!(
        "If the circumcentre of a cell lies in the domain and away from the boundary, its radius-edge ratio is at most \
         {bound:.4}. The first and last intervals include the counts beyond the axis."
    );
    let variants = all.into_iter().map(variant).collect();
    PageFigure { id: "mesh-quality", title: "Quality", caption, variants }
}

/// A quantity of a part of the run: name, unit, value.
type Measure<T> = (&'static str, &'static str, fn(&T) -> f64);

/// Draws the points and the cost of each stage.
fn stages(stages: &[StageReport]) -> Option<PageFigure> {
    let mut measures: Vec<Measure<StageReport>> = vec![
        ("points", "points", |s| s.points as f64),
        ("candidates", "candidates", |s| s.candidates as f64),
        ("completion rounds", "rounds", |s| s.completion_rounds as f64),
        ("set rounds", "rounds", |s| s.set_rounds as f64),
    ];
    measures.extend::<[Measure<StageReport>; 6]>([
        ("rounds", "rounds", |s| s.rounds as f64),
        ("messages", "messages", |s| s.messages as f64),
        ("bytes", "B", |s| s.bytes as f64),
        ("work", "operations", |s| s.work as f64),
        ("depth", "steps", |s| s.depth as f64),
        ("time (measured)", "s", |s| s.seconds),
    ]);
    let mut table = DataTable::new(&["stage", "candidates", "points", "completion rounds", "set rounds"]);
    table.columns.extend(TOOK.map(str::to_owned));
    for s in stages {
        let made = [json!(s.candidates), json!(s.points), json!(s.completion_rounds), json!(s.set_rounds)];
        let took = [json!(s.rounds), json!(s.messages), json!(s.bytes), json!(s.work), json!(s.depth)];
        let row = [json!(s.name)].into_iter().chain(made).chain(took).chain([json!(s.seconds)]);
        table.rows.push(row.collect());
    }
    let variants = variants(stages, |s| s.name.clone(), &measures, &table);
    let caption =
        "The stages mesh segments, facets and the volume in this order. Rounds, messages, bytes, operations and steps \
         are counts of the modelled machine over all its runs in a stage; seconds are measured."
            .to_owned();
    let title = "Meshing by stage";
    (!variants.is_empty()).then_some(PageFigure { id: "mesh-stages", title, caption, variants })
}

/// The quantities that both stages and phases have.
const TOOK: [&str; 6] = ["rounds", "messages", "bytes", "work", "depth", "seconds (measured)"];

/// Draws the cost of the phases, summed over all stages; the table lists each stage.
fn phases(phases: &[StagePhase]) -> Option<PageFigure> {
    let mut sums: Vec<StagePhase> = Vec::new();
    let mut table = DataTable::new(&["stage", "phase", "runs"]);
    table.columns.extend(TOOK.map(str::to_owned));
    for p in phases {
        match sums.iter_mut().find(|sum| sum.phase == p.phase) {
            Some(sum) => add(sum, p),
            None => sums.push(p.clone()),
        }
        let took = [json!(p.rounds), json!(p.messages), json!(p.bytes), json!(p.work), json!(p.depth)];
        let row = [json!(p.stage), json!(p.phase), json!(p.runs)].into_iter().chain(took);
        table.rows.push(row.chain([json!(p.seconds)]).collect());
    }
    let measures: [Measure<StagePhase>; 6] = [
        ("work", "operations", |p| p.work as f64),
        ("depth", "steps", |p| p.depth as f64),
        ("rounds", "rounds", |p| p.rounds as f64),
        ("messages", "messages", |p| p.messages as f64),
        ("bytes", "B", |p| p.bytes as f64),
        ("time (measured)", "s", |p| p.seconds),
    ];
    let variants = variants(&sums, |p| p.phase.to_string(), &measures, &table);
    let caption = "The phases of the machine, summed over all its runs: independent sets of candidates, and \
                   triangulations of the current points, without operations. The table lists each stage."
        .to_owned();
    let title = "Meshing by phase";
    (!variants.is_empty()).then_some(PageFigure { id: "mesh-phases", title, caption, variants })
}

/// Adds the counts of a phase in another stage.
fn add(sum: &mut StagePhase, other: &StagePhase) {
    sum.runs += other.runs;
    sum.rounds += other.rounds;
    sum.messages += other.messages;
    sum.bytes += other.bytes;
    sum.work += other.work;
    sum.depth += other.depth;
    sum.seconds += other.seconds;
}

/// Draws each quantity that is not zero everywhere.
fn variants<T>(
    parts: &[T],
    name: impl Fn(&T) -> String,
    measures: &[Measure<T>],
    table: &DataTable,
) -> Vec<Variant> {
    let mut variants = Vec::new();
    for &(measure, unit, value) in measures {
        let named: Vec<(String, f64)> =
            parts.iter().map(|p| (name(p), value(p))).filter(|p| p.1 > 0.0).collect();
        if !named.is_empty() {
            let rows: Vec<Bar<'_>> =
                named.iter().map(|(name, value)| Bar { name, group: None, value: *value }).collect();
            let label = if unit == measure { measure.to_owned() } else { format!("{measure} [{unit}]") };
            let body = bars(&rows, &label);
            variants.push(Variant { name: measure.to_owned(), body, table: table.clone() });
        }
    }
    variants
}
