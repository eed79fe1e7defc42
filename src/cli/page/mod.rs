//! A self-contained page from the reports of runs and meshes: figures, their tables, the partition in space, and
//! the mesh with a cutting plane.
//!
//! [`Page::of`] takes the texts of reports (`--json`) and of sweeps (one object per line). [`Page::html`] returns the
//! page, and [`Page::figures`] returns its figures as SVG. The scripts of the page only select figures, show tables
//! and draw the sampled points. The page loads nothing from the network.
//!
#![doc = include_str!("overview.md")]

mod axes;
mod bars;
mod card;
mod cells;
mod data;
mod error;
mod figure;
mod fit;
mod heat;
pub(crate) mod histograms;
mod html;
mod laws;
mod levels;
mod mesh;
mod plot;
mod svg;
mod triangulation;

pub use data::RunData;
pub use error::PageError;
pub use figure::{DataTable, PageFigure, Variant};

use data::Entry;
use mesh::MeshData;

/// A page.
#[derive(Clone, Debug)]
pub struct Page {
    runs: Vec<RunData>,
    /// Index of the run whose rounds, traffic and points are shown.
    shown: Option<usize>,
    figures: Vec<PageFigure>,
    /// The meshes, of which the first is shown.
    meshes: Vec<MeshData>,
    mesh_figures: Vec<PageFigure>,
}

impl Page {
    /// Creates the page from input texts, each with its file name.
    ///
    /// # Errors
    /// Fails if a text contains no report.
    pub fn of(texts: &[(String, String)]) -> Result<Page, PageError> {
        let (mut runs, mut meshes) = (Vec::new(), Vec::new());
        for (name, text) in texts {
            for entry in data::read(name, text)? {
                match entry {
                    Entry::Run(run) => runs.push(run),
                    Entry::Mesh(mesh) => meshes.push(*mesh),
                }
            }
        }
        if runs.is_empty() && meshes.is_empty() {
            return Err(PageError::Empty);
        }
        let shown = runs.iter().position(RunData::is_whole);
        let mut figures = Vec::new();
        if let Some(run) = shown.map(|at| &runs[at]) {
            figures.extend(triangulation::figures(run));
            figures.extend(bars::proofs(run));
            figures.extend(heat::timeline(run));
            figures.extend(heat::traffic(run));
            figures.extend(bars::phases(run));
            figures.extend(levels::figures(run));
        }
        figures.extend(laws::figures(&runs));
        let mesh_figures = meshes.first().map(mesh::figures).unwrap_or_default();
        Ok(Page { runs, shown, figures, meshes, mesh_figures })
    }

    /// Returns the HTML text.
    ///
    /// # Errors
    /// Fails if a number cannot be written as JSON.
    pub fn html(&self) -> Result<String, serde_json::Error> {
        html::page(self)
    }

    /// Returns the number of leading figures that show the data.
    fn data_figures(&self) -> usize {
        self.figures.iter().take_while(|figure| triangulation::FIGURES.contains(&figure.id)).count()
    }

    fn all_figures(&self) -> impl Iterator<Item = &PageFigure> {
        self.figures.iter().chain(&self.mesh_figures)
    }

    /// Returns the file name and the text of every figure.
    pub fn figures(&self) -> Vec<(String, String)> {
        let named = |figure: &PageFigure| {
            let single = figure.variants.len() == 1;
            let each = |v: &Variant| {
                let name =
                    if single { figure.id.to_owned() } else { format!("{}-{}", figure.id, slug(&v.name)) };
                (format!("{name}.svg"), v.body.alone(figure.title))
            };
            figure.variants.iter().map(each).collect::<Vec<_>>()
        };
        self.all_figures().flat_map(named).collect()
    }
}

/// Reduces a name to letters, digits and single hyphens.
fn slug(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty());
    words.map(str::to_ascii_lowercase).collect::<Vec<_>>().join("-")
}
