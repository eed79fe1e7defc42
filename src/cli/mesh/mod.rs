//! `septet mesh`.

mod options;
mod show;

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::mesh::show::{figures, summary};
use septet_core::mesh::labelled::Labelled;
use septet_core::mesh::view::{DEFAULT_CELLS, MeshPicture};
use septet_core::mesh::{
    Dimension, Made, MakeError, MeshError, MeshKeep, MeshSpec, Promise, accept, make_of, remedy,
};
use septet_core::run::memory::peak_rss;
use septet_core::{Door, Remedy};
use septet_io::Role;
use septet_io::read::{AnyInput, DomainFile, read_domains, read_sizes};
use septet_io::without_gz;
use septet_io::write::{OutputError, WriteOptions, check_dimension};
use septet_lab::report::mesh::tables::TABLES;
use septet_lab::report::mesh::{
    CheckedMesh, MeshContext, MeshReport, MeshSeconds, feature_name, unscaled_measure,
};
use septet_meshing::Accepted;
use septet_meshing::conformity::Conformity;
use septet_meshing::defect::Defect;
use septet_meshing::domain::Domain;
use septet_meshing::facet::Triangulate;
use septet_meshing::input::Input;
use septet_meshing::mesh::Mesh;
use septet_meshing::repair::Change;
use septet_meshing::size::SizeError;
use tracing_subscriber::layer::Identity;

use super::errors::{Code, Failure};
use super::files::{self, write_text};
use super::formats::write_mesh;
use super::input::{refuse_list, watched};
use super::instruments::{Tables, check_trace, traced};
use super::progress::Talk;
use super::report::write_figures;
use super::summary::{row, written};
use super::text::{self, counted};
pub use options::MeshArgs;

/// Maximum number of small angles, ignored elements and defects of a mesh that are listed.
const SHOWN: usize = 20;

/// Number of worst cells of each kind in the report.
const WORST: usize = 10;

/// Reads and checks the domain, and meshes it unless `--check` is set.
pub fn run(args: &MeshArgs, talk: &Talk) -> Result<(), Failure> {
    let start = Instant::now();
    let mut request = args.request()?;
    septet_core::cores::limit(request.run.machine.thread_count());
    request.run.control.cancel = Some(talk.cancel.clone());
    for file in std::iter::once(&args.domain).chain(&args.surfaces).chain(&args.size_field) {
        refuse_list(file, "a domain or a file of sizes is one file")?;
    }
    check_trace(&args.tracing)?;
    let tables = Tables::of(args.profile.as_deref(), &TABLES)?;
    outputs(args, &tables)?;
    let domains: Vec<PathBuf> = std::iter::once(&args.domain).chain(&args.surfaces).cloned().collect();
    let file = watched(talk, move |progress| read_domains(&domains, progress))??;
    if let Some(path) = &args.size_field {
        let sizes = path.clone();
        request.sizes.field = Some(watched(talk, move |progress| read_sizes(&sizes, progress))??);
    }
    talk.check();
    talk.clear();
    for note in &file.notes {
        talk.note(format!("note: {note}"));
    }
    let job = Job { args, tables, request, first_id: file.first_id, start, talk };
    match &file.input {
        AnyInput::Plane(input) => job.checked(&file, input),
        AnyInput::Space(input) => job.checked(&file, input),
    }
}

/// Checks that all output files can be written.
fn outputs(args: &MeshArgs, tables: &Tables) -> Result<(), Failure> {
    let options = args.write_options();
    // No worker holds the points of a mesh, because its vertices are not the points of one run.
    let has_pieces = |o: &&PathBuf| options.format_of(o).is_ok_and(|format| !format.has(Role::Mesh));
    if let Some(path) = args.output.iter().find(has_pieces) {
        return Err(OutputError::NoPieces { path: path.clone() }.into());
    }
    let texts = args.json.iter().chain(&args.tracing.trace).map(PathBuf::as_path);
    let texts: Vec<&Path> = texts.chain(tables.paths()).collect();
    // The points of a .poly file may be in a .node file of the same name.
    let node = without_gz(&args.domain).0.with_extension("node");
    let read = [Some(&args.domain), args.size_field.as_ref(), Some(&node).filter(|n| n.is_file())];
    let read: Vec<&Path> = read.into_iter().flatten().chain(&args.surfaces).map(PathBuf::as_path).collect();
    files::check_as(&read, &args.output, &options, &texts)?;
    args.writing.check(&args.output)
}

/// One call of the command.
struct Job<'a> {
    args: &'a MeshArgs,
    tables: Tables,
    request: MeshSpec,
    first_id: u64,
    start: Instant,
    talk: &'a Talk,
}

/// A mesh with its quality and conformity, and its picture.
struct Found<P: Triangulate> {
    made: Made<P>,
    picture: Option<MeshPicture>,
}

impl Job<'_> {
    fn checked<P: Dimension>(&self, file: &DomainFile, input: &Input<P>) -> Result<(), Failure> {
        let (args, talk) = (self.args, self.talk);
        let domain = match accept(input, &self.request) {
            Ok(Accepted { domain, changes, .. }) => {
                self.say(&changes, file.first_id);
                domain
            }
            Err(defects) => {
                for defect in &defects {
                    talk.fault(format!("{}: {}", defect.kind(), defect.in_file(file.first_id)));
                }
                return Err(refusal(args, &defects));
            }
        };
        if args.check {
            talk.log(None::<Identity>);
            describe(args, file, &domain, talk);
            return Ok(());
        }
        self.meshed(&domain)
    }

    /// Prints what was done to the domain.
    fn say(&self, changes: &[Change], first_id: u64) {
        let (repairs, notes): (Vec<_>, Vec<_>) = changes.iter().partition(|change| change.is_repair());
        let shown = if self.args.check { repairs.len() } else { SHOWN };
        for note in notes {
            self.talk.note(format!("note: {}", note.in_file(first_id)));
        }
        for repair in repairs.iter().take(shown) {
            self.talk.note(format!("repair: {}", repair.in_file(first_id)));
        }
        if repairs.len() > shown {
            self.talk.note(format!("repair: {} more, which --check lists", repairs.len() - shown));
        }
    }

    fn meshed<P: Dimension>(&self, domain: &Domain<P>) -> Result<(), Failure> {
        let (args, request, talk) = (self.args, &self.request, self.talk);
        let read_seconds = self.start.elapsed().as_secs_f64();
        talk.check();
        args.check_boundary(!request.remeshes(domain))?;
        let options = args.write_options();
        args.output.iter().try_for_each(|output| check_dimension(output, &options, P::DIM))?;
        let mut files = Vec::new();
        let Found { made: found, picture } = traced(&args.tracing, talk, &mut files, || self.found(domain))?;
        let broken = self.broken(&found.conformity);
        let checked = self.start.elapsed().as_secs_f64();
        if broken.is_none() {
            files.extend(self.write(domain, &found.mesh)?);
        }
        let total_seconds = self.start.elapsed().as_secs_f64();
        talk.clear();
        let judge_seconds = checked - read_seconds - found.seconds;
        let (mesh_seconds, write_seconds) = (found.seconds, total_seconds - checked);
        let around = MeshContext {
            input: &args.domain.display().to_string(),
            outputs: &args.output,
            first_id: self.first_id,
            seconds: MeshSeconds { read_seconds, mesh_seconds, judge_seconds, write_seconds, total_seconds },
            peak_rss_bytes: peak_rss(),
        };
        let checked = CheckedMesh {
            domain,
            request,
            mesh: &found.mesh,
            stages: &found.stages,
            quality: &found.quality,
            conformity: &found.conformity,
            run_log: &found.run_log,
            picture: picture.as_ref(),
        };
        self.finish(&checked, &around, files)?;
        broken.map_or(Ok(()), Err)
    }

    /// Generates the mesh and measures it. A mesh that does not conform is returned as well, so that it can be
    /// reported.
    fn found<P: Dimension>(&self, domain: &Domain<P>) -> Result<Found<P>, Failure> {
        let (args, talk) = (self.args, self.talk);
        let most = args.json.as_ref().map_or(0, |_| args.view.unwrap_or(DEFAULT_CELLS)) as usize;
        let mut made = match make_of(domain, &self.request, MeshKeep { owned: most, worst: WORST }) {
            Ok(made) => made,
            Err(MakeError::NotConforming(made)) => *made,
            Err(MakeError::Shapeless(conformity)) => {
                let broken = self.broken(&conformity);
                return Err(broken.unwrap_or_else(|| Failure::new(Code::Rejected, "the mesh is degenerate")));
            }
            Err(MakeError::Mesh(error)) => return Err(self.named(domain, error)),
            Err(error) => return Err(Failure::of(Code::Failed, &error, error.remedy())),
        };
        let cells = made.mesh.cells.len();
        let owners = made.owners.take();
        let picture = (cells <= most).then(|| MeshPicture::of(domain, &made.mesh, &made.size, owners));
        if picture.is_none() && most > 0 {
            talk.note(format!(
                "note: the report has no picture: the mesh has {cells} cells, --view allows {most}"
            ));
        }
        Ok(Found { made, picture })
    }

    /// Writes the report, the figures and the tables, and prints the summary.
    fn finish<P: Triangulate>(
        &self,
        checked: &CheckedMesh<'_, P>,
        around: &MeshContext<'_>,
        mut files: Vec<PathBuf>,
    ) -> Result<(), Failure> {
        let (args, talk) = (self.args, self.talk);
        let report = MeshReport::of(checked, around);
        if let Some(path) = &args.json {
            let text = report.to_json();
            let text =
                text.map_err(|e| Failure::new(Code::Failed, format!("the report cannot be written: {e}")))?;
            write_text(path, &(text + "\n"))?;
        }
        if let Some(directory) = &args.svg {
            write_figures(
                &figures(checked.quality, Promise::of(self.request.sizes.lipschitz)),
                directory,
                talk,
            )?;
        }
        let rendered = |format, which| report.tables(format, which);
        files.extend(self.tables.write(&rendered)?);
        for line in summary(checked, self.first_id) {
            talk.note(line);
        }
        let seconds =
            [around.seconds.mesh_seconds, around.seconds.write_seconds, around.seconds.total_seconds];
        let [mesh, write, total] = seconds.map(text::seconds);
        talk.note(row("time", format!("mesh {mesh}, write {write}, total {total}")));
        if let Some(peak) = around.peak_rss_bytes {
            talk.note(row("memory", format!("{} at the peak", text::bytes(peak))));
        }
        for line in written(&files) {
            talk.note(line);
        }
        self.tables.print(&rendered);
        Ok(())
    }

    /// Prints the ids of the missing features in the file, and returns the failure.
    fn named<P: Triangulate>(&self, domain: &Domain<P>, error: MeshError) -> Failure {
        if let MeshError::Coarse { feature, .. } = &error {
            self.talk.clear();
            self.talk.fault(feature_name(domain, *feature, self.first_id));
        }
        if let MeshError::Missing { features, .. } = &error {
            self.talk.clear();
            for &(feature, parts) in features.iter().take(SHOWN) {
                let name = feature_name(domain, feature, self.first_id);
                self.talk.fault(format!("{name}: {} cannot be recovered", counted(parts as u64, "part")));
            }
        }
        error.into()
    }

    /// Prints the first defects of a mesh that does not conform, and returns the failure. Returns `None` if it
    /// conforms.
    fn broken(&self, conformity: &Conformity) -> Option<Failure> {
        let defects = &conformity.defects;
        if defects.is_empty() {
            return None;
        }
        self.talk.clear();
        for defect in defects.iter().take(SHOWN) {
            self.talk.fault(format!("mesh: {defect}"));
        }
        let number = counted(defects.len() as u64, "defect");
        let message = format!("the mesh does not conform to its domain: {number}");
        Some(
            Failure::new(Code::Rejected, message)
                .help("no mesh was written; please report this defect with the input"),
        )
    }

    fn write<P: Triangulate>(&self, domain: &Domain<P>, mesh: &Mesh<P>) -> Result<Vec<PathBuf>, Failure> {
        let (args, talk) = (self.args, self.talk);
        let options = WriteOptions { first_id: self.first_id, ..args.write_options() };
        let labelled = Labelled::of(domain, mesh);
        let mut files = Vec::new();
        for output in &args.output {
            talk.check();
            let stage = format!("writing {}", output.display());
            let mut progress = |done: u64, total: u64| talk.stage(&stage, done, Some(total));
            files.extend(write_mesh(output, &labelled.view(), &options, &mut progress)?);
        }
        Ok(files)
    }
}

impl From<MeshError> for Failure {
    fn from(error: MeshError) -> Self {
        let code = match &error {
            // The number of columns of a size field is a property of its file.
            MeshError::Dimension { what: "size field", .. } | MeshError::Coarse { .. } => Code::Input,
            MeshError::Size(SizeError::TooFine(_)) | MeshError::TooMany { .. } | MeshError::Memory { .. } => {
                Code::Limit
            }
            MeshError::Dimension { .. } | MeshError::Size(_) | MeshError::Unsupported(_) => Code::Usage,
            MeshError::Missing { .. } => Code::Rejected,
            _ => Code::Failed,
        };
        let is_usage = matches!(error, MeshError::Size(_) | MeshError::Unsupported(_));
        let help = if is_usage { "see `septet mesh --help`" } else { "--check checks the domain only" };
        match error {
            MeshError::Run(error) => error.into(),
            error => Failure::of(code, &error, error.remedy()).or_help(help),
        }
    }
}

fn refusal(args: &MeshArgs, defects: &[Defect]) -> Failure {
    let number = counted(defects.len() as u64, "defect");
    let is_strict = args.mesh.options().has("strict");
    let omit = Remedy::of("omit {strict}, or fix the defects of the domain");
    let remedy = if is_strict { omit } else { remedy(defects) };
    let help = remedy.and("; ids are as in the file, and facets are numbered in file order");
    Failure::new(Code::Input, format!("{} has {number}", args.domain.display()))
        .help(help.spelled(Door::Shell))
}

/// Prints the result of `--check` for a valid domain.
fn describe<P: Triangulate>(args: &MeshArgs, file: &DomainFile, domain: &Domain<P>, talk: &Talk) {
    let inside = domain.components.iter().filter(|c| c.inside).count();
    let regions = domain.components.iter().filter(|c| c.region.is_some()).count();
    talk.note(format!(
        "septet: {} is a domain: {}, {}, {}, {}, {}, {}, {} {}",
        args.domain.display(),
        counted(domain.points().len() as u64, "point"),
        counted(domain.corners.len() as u64, "corner"),
        counted(domain.segments.len() as u64, "segment"),
        counted(domain.facets.len() as u64, "facet"),
        counted(inside as u64, "component"),
        counted(regions as u64, "region"),
        if P::DIM == 2 { "area" } else { "volume" },
        unscaled_measure(domain),
    ));
    for piece in domain.left_out.iter().take(SHOWN) {
        talk.note(format!("note: {} lies outside the domain and is ignored", piece.in_file(file.first_id)));
    }
    if domain.left_out.len() > SHOWN {
        talk.note(format!("note: {} more elements are ignored", domain.left_out.len() - SHOWN));
    }
    let small = domain.small_angles(90.0);
    for angle in small.iter().take(SHOWN) {
        let name = |feature| feature_name(domain, feature, file.first_id);
        let at = domain.simplices.place(angle.at);
        let [a, b] = angle.features.map(name);
        talk.note(format!("{a} and {b}, {:.3} degrees, at {at}", angle.degrees()));
    }
    if small.len() > SHOWN {
        talk.note(format!("{} more angles are below 90 degrees", small.len() - SHOWN));
    }
}

#[cfg(test)]
mod tests;
