//! A mesh on the page: its figures with their tables, and its summary. The picture is the page's script's.

mod data;
mod summary;

use serde_json::{Value, json};

pub(super) use data::{MeshData, read};
pub(super) use summary::{headline, section};

use data::{Phase, Stage, Took};

use super::bars::bars;
use super::histograms::{Drawn, draw, table};
use super::{Figure, Table, Variant};

/// The figures of a mesh.
pub(super) fn figures(mesh: &MeshData) -> Vec<Figure> {
    let mut figures = vec![quality(mesh)];
    figures.extend(stages(&mesh.file.stages));
    figures.extend(phases(&mesh.file.phases));
    figures
}

/// Histograms of what is promised and of what it is worth.
fn quality(mesh: &MeshData) -> Figure {
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
        "Cells whose circumcentres lie in the domain, away from its boundary, are promised a radius-edge ratio of at \
         most {bound:.4}. Counts beyond the ends of an axis are told at them."
    );
    let variants = all.into_iter().map(variant).collect();
    Figure { id: "mesh-quality", title: "Quality", caption, variants }
}

/// What is measured of a part of the run: name, unit, value.
type Measure<T> = (&'static str, &'static str, fn(&T) -> f64);

/// What each stage made and took.
fn stages(stages: &[Stage]) -> Option<Figure> {
    let mut measures: Vec<Measure<Stage>> = vec![
        ("points", "points", |s| s.points as f64),
        ("candidates", "candidates", |s| s.candidates as f64),
        ("completion rounds", "rounds", |s| s.completion_rounds as f64),
        ("set rounds", "rounds", |s| s.set_rounds as f64),
    ];
    measures.extend::<[Measure<Stage>; 6]>([
        ("rounds", "rounds", |s| s.rounds as f64),
        ("messages", "messages", |s| s.messages as f64),
        ("bytes", "B", |s| s.bytes as f64),
        ("work", "operations", |s| s.work as f64),
        ("depth", "steps", |s| s.depth as f64),
        ("time (measured)", "s", |s| s.seconds),
    ]);
    let mut table = Table::new(&["stage", "candidates", "points", "completion rounds", "set rounds"]);
    table.columns.extend(TOOK.map(str::to_owned));
    for s in stages {
        let mut row = vec![json!(s.name), json!(s.candidates), json!(s.points), json!(s.completion_rounds)];
        row.push(json!(s.set_rounds));
        row.extend(took(&s.took()));
        table.rows.push(row);
    }
    let variants = variants(stages, |s| s.name.clone(), &measures, &table);
    let caption =
        "Points of segments, facets and the volume, one stage after the other. Rounds, messages, bytes, operations and \
         steps are counts of the modelled machine over all its runs in the stage; seconds are measured."
            .to_owned();
    let title = "Meshing stage by stage";
    (!variants.is_empty()).then_some(Figure { id: "mesh-stages", title, caption, variants })
}

/// Heads of [`took`].
const TOOK: [&str; 6] = ["rounds", "messages", "bytes", "work", "depth", "seconds (measured)"];

fn took(t: &Took) -> [Value; 6] {
    [json!(t.rounds), json!(t.messages), json!(t.bytes), json!(t.work), json!(t.depth), json!(t.seconds)]
}

/// What the machine's phases took over all stages; the table has each stage by itself.
fn phases(phases: &[Phase]) -> Option<Figure> {
    let mut sums: Vec<(String, Took)> = Vec::new();
    let mut table = Table::new(&["stage", "phase", "runs"]);
    table.columns.extend(TOOK.map(str::to_owned));
    for p in phases {
        let at = sums.iter().position(|(name, _)| *name == p.phase).unwrap_or_else(|| {
            sums.push((p.phase.clone(), Took::default()));
            sums.len() - 1
        });
        sums[at].1.add(&p.took());
        let mut row = vec![json!(p.stage), json!(p.phase), json!(p.runs)];
        row.extend(took(&p.took()));
        table.rows.push(row);
    }
    let measures: [Measure<(String, Took)>; 6] = [
        ("work", "operations", |p| p.1.work as f64),
        ("depth", "steps", |p| p.1.depth as f64),
        ("rounds", "rounds", |p| p.1.rounds as f64),
        ("messages", "messages", |p| p.1.messages as f64),
        ("bytes", "B", |p| p.1.bytes as f64),
        ("time (measured)", "s", |p| p.1.seconds),
    ];
    let variants = variants(&sums, |p| p.0.clone(), &measures, &table);
    let caption = "The phases of the machine, summed over all its runs: independent sets of candidates, and \
                   triangulations of the points so far. The table tells stages apart."
        .to_owned();
    let title = "Meshing phase by phase";
    (!variants.is_empty()).then_some(Figure { id: "mesh-phases", title, caption, variants })
}

impl Took {
    fn add(&mut self, other: &Took) {
        self.rounds += other.rounds;
        self.messages += other.messages;
        self.bytes += other.bytes;
        self.work += other.work;
        self.depth += other.depth;
        self.seconds += other.seconds;
    }
}

/// A drawing for each measure that is not zero throughout.
fn variants<T>(
    parts: &[T],
    name: impl Fn(&T) -> String,
    measures: &[Measure<T>],
    table: &Table,
) -> Vec<Variant> {
    let mut variants = Vec::new();
    for &(measure, unit, value) in measures {
        let named: Vec<(String, f64)> =
            parts.iter().map(|p| (name(p), value(p))).filter(|p| p.1 > 0.0).collect();
        if !named.is_empty() {
            let rows: Vec<(&str, bool, f64)> = named.iter().map(|(n, v)| (n.as_str(), true, *v)).collect();
            let label = if unit == measure { measure.to_owned() } else { format!("{measure} [{unit}]") };
            let body = bars(&rows, &label);
            variants.push(Variant { name: measure.to_owned(), body, table: table.clone() });
        }
    }
    variants
}
