//! The input points, which are read from a file or standard input, or generated.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use septet_core::generate::{Request, generate, parse_sample};
use septet_core::model::Points;
use septet_core::{Error, Spec};
use septet_geometry::range::RangeError;
use septet_io::read::{
    CellFile, Column, FileList, FileReading, InputError, ListedFile, PointFile, PointList, ReadOptions,
    ReadProgress, apart, read, read_list, read_mesh,
};

use super::errors::{Code, Failure};
use super::far::Far;
use super::files;
use super::formats::{check_reading, read_options};
use super::given::Options;
use super::gzip;
use super::progress::Talk;
use super::text::{counted, place_of};

/// The points of a run.
pub struct Loaded {
    /// The points.
    pub points: Points,
    /// The heights of the points, if they are a terrain.
    pub heights: Option<Vec<f64>>,
    /// The weights of the points, if they have some.
    pub weights: Option<Vec<f64>>,
    /// The Lipschitz constant of an f-spaced set.
    pub spacing: Option<f64>,
    /// Number of points that were dropped while reading.
    pub skipped: u64,
    /// Index in the file of each point, if points were dropped.
    pub source_index: Option<Vec<u64>>,
    /// First id of a `.node` file.
    pub first_id: u64,
    /// Other columns of a text table, if they are kept.
    pub columns: Vec<Column>,
    /// Files of a list of files, in their order. Empty for other inputs.
    pub files: Vec<ListedFile>,
    /// What was read of the files. `None` for a sample.
    pub reading: Option<FileReading>,
    /// Measured time to read or generate the points, in seconds.
    pub seconds: f64,
}

impl Loaded {
    /// Returns the row of the input of a point.
    pub fn row(&self, point: usize) -> usize {
        self.source_index.as_ref().map_or(point, |rows| rows[point] as usize)
    }

    /// Returns the points of a file, or of the files of a list.
    fn of(file: PointFile, files: Vec<ListedFile>, start: Instant, talk: &Talk) -> Self {
        talk.check();
        for note in &file.notes {
            talk.note(format!("note: {note}"));
        }
        if let Some(far) = Far::of(&file.points, file.source_index.as_deref()) {
            talk.note(far.describe(&files));
        }
        if file.skipped > 0 {
            talk.note(format!("note: {} skipped", counted(file.skipped as u64, "invalid point")));
        }
        Loaded {
            points: file.points,
            heights: file.heights,
            weights: file.weights,
            spacing: None,
            skipped: file.skipped as u64,
            source_index: file.source_index,
            first_id: file.first_id,
            columns: file.columns,
            files,
            reading: Some(file.reading),
            seconds: start.elapsed().as_secs_f64(),
        }
    }
}

/// Converts an error of a run. An error about points gives the file and the positions of the points in it. `files` are the
/// files of a list, and `at` returns the row of the input of each point.
pub fn placed(error: Error, files: &[ListedFile], input: &str, at: impl Fn(usize) -> usize) -> Failure {
    match error {
        Error::Points(error) => of_points(&renumbered(error, at), files, input),
        Error::Periodic(mut error) if error.is_of_point() => {
            let name = if input == "-" { "standard input" } else { input };
            let mut place = String::new();
            if let Some(index) = error.point() {
                *index = at(*index);
                place =
                    if files.len() > 1 { place_of(files, *index as u64).unwrap_or_default() } else { place };
            }
            let message = format!("{name}: {error} (points counted from 0{place})");
            Failure::of(Code::Input, &message, error.remedy())
        }
        error => error.into(),
    }
}

/// Returns the error with other numbers of its points.
fn renumbered(mut error: RangeError, at: impl Fn(usize) -> usize) -> RangeError {
    match &mut error {
        RangeError::NotFinite { index, .. } => *index = at(*index),
        RangeError::Spread { low, high, .. } => (*low, *high) = (at(*low), at(*high)),
    }
    error
}

/// Returns the failure for points that cannot be triangulated. `files` are the files of a list.
fn of_points(error: &RangeError, files: &[ListedFile], input: &str) -> Failure {
    let rows = match *error {
        RangeError::NotFinite { index, .. } => vec![index],
        RangeError::Spread { low, high, .. } => vec![low, high],
    };
    let name = if input == "-" { "standard input" } else { input };
    let is_list = files.len() > 1;
    let places = rows.into_iter().filter_map(|row| place_of(files, row as u64)).filter(|_| is_list);
    let places: String = places.collect();
    Failure::new(Code::Input, format!("{name}: {error} (points counted from 0{places})"))
        .help("round the coordinates to a common grid, or drop these points")
}

/// The input of a command that reads points.
pub enum Input<'a> {
    /// A sample to be generated.
    Sample(Request),
    /// A file, or `-` for standard input.
    File(&'a str),
    /// A list of files.
    List(FileList),
}

impl<'a> Input<'a> {
    /// Parses an argument, and finds the files of a list. `dimension` is the value of `-d`.
    pub fn of(argument: &'a str, dimension: Option<usize>, talk: &Talk) -> Result<Self, Failure> {
        if let Some(request) = sample(argument, dimension)? {
            return Ok(Input::Sample(request));
        }
        let owned = argument.to_owned();
        let list = watched(talk, move |_| FileList::of_argument(&owned))?;
        Ok(list?.map_or(Input::File(argument), Input::List))
    }

    /// Returns `true` for a sample.
    pub fn is_sample(&self) -> bool {
        matches!(self, Input::Sample(_))
    }

    /// Returns all files that are read, so that no output overwrites them.
    pub fn files(&self) -> Vec<&Path> {
        match self {
            Input::Sample(_) | Input::File("-") => Vec::new(),
            Input::File(name) => vec![Path::new(name)],
            Input::List(list) => list.files().iter().map(PathBuf::as_path).chain(list.source()).collect(),
        }
    }

    /// Reads or generates the points.
    pub fn load(&self, options: &ReadOptions, talk: &Talk) -> Result<Loaded, Failure> {
        match self {
            Input::Sample(request) => make(request, talk),
            Input::File(name) => open(name, options, talk),
            Input::List(list) => open_list(list, options, talk),
        }
    }
}

/// Refuses an input that names several files. `reason` states what the command reads.
pub fn refuse_list(input: &Path, reason: &str) -> Result<(), Failure> {
    if !input.to_str().is_some_and(FileList::is_named_by) {
        return Ok(());
    }
    let message = format!("{}: a pattern or list of files cannot be given here: {reason}", input.display());
    Err(Failure::new(Code::Usage, message).help("give the name of a single file"))
}

/// Reads or generates the points of a command that writes no triangulation, after checking that `json` can be written and
/// is not the input.
pub fn load(
    name: &str,
    (given, spec): (&Options<Spec>, &Spec),
    json: Option<&Path>,
    talk: &Talk,
) -> Result<Loaded, Failure> {
    let input = Input::of(name, spec.input.dimension, talk)?;
    check_reading(given, input.is_sample())?;
    let texts: Vec<&Path> = json.into_iter().collect();
    files::check(&input.files(), &[], &texts)?;
    input.load(&read_options(&spec.input)?, talk)
}

/// Parses the sample that an input describes, if it begins with `sample:`. `dimension` is the value of `-d`.
pub fn sample(input: &str, dimension: Option<usize>) -> Result<Option<Request>, Failure> {
    let Some(sample) = input.strip_prefix("sample:") else { return Ok(None) };
    let mut request = parse_sample(sample)?;
    if let Some(d) = dimension {
        let stated = sample.split(',').any(|part| part.trim().starts_with("d="));
        if stated && request.dimension != d {
            let message = format!("-d {d} contradicts {input}");
            return Err(Failure::new(Code::Usage, message).help("state the dimension only once"));
        }
        request.dimension = d;
    }
    Ok(Some(request))
}

/// Generates a sample.
pub fn make(request: &Request, talk: &Talk) -> Result<Loaded, Failure> {
    let start = Instant::now();
    let label = format!("generating {}", request.kind);
    talk.stage(&label, 0, Some(request.n));
    let made = generate(request, &mut |_, done, total| talk.stage(&label, done, Some(total)))?;
    talk.check();
    for note in &made.notes {
        talk.note(format!("note: {note}"));
    }
    Ok(Loaded {
        points: made.points,
        heights: None,
        weights: None,
        spacing: made.spacing.map(|s| s.lipschitz),
        skipped: 0,
        source_index: None,
        first_id: 0,
        columns: Vec::new(),
        files: Vec::new(),
        reading: None,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Returns the failure for a file that cannot be read. If the name of a missing file looks like a sample, the help
/// suggests the correct form.
fn with_sample(error: InputError, path: &str) -> Failure {
    let is_sample = matches!(error, InputError::Missing { .. }) && parse_sample(path).is_ok();
    let failure = Failure::from(error);
    if is_sample { failure.help(format!("for a generated sample, use sample:{path}")) } else { failure }
}

/// Reads on a thread of its own, and shows the progress. Fails as soon as Ctrl-C is pressed, so that several processes
/// can agree on this failure.
pub fn watched<T: Send + 'static>(
    talk: &Talk,
    read: impl FnOnce(&mut ReadProgress<'_>) -> T + Send + 'static,
) -> Result<T, Failure> {
    let at: Arc<Mutex<(u64, Option<u64>)>> = Arc::default();
    let reported = at.clone();
    let work = move || {
        read(&mut |done, total| *reported.lock().unwrap_or_else(PoisonError::into_inner) = (done, total))
    };
    talk.show("reading", 0, None);
    let look = &mut || {
        let (done, total) = *at.lock().unwrap_or_else(PoisonError::into_inner);
        talk.show("reading", done, total);
        talk.is_cancelled()
    };
    let done = apart(work, look).map_err(|error| {
        let message = format!("the thread that reads does not start: {error}");
        Failure::new(Code::Failed, message).help("end other programs, or raise the limit of threads")
    })?;
    done.ok_or_else(Failure::interrupted)
}

/// Reads points from a file or standard input.
pub fn open(path: &str, options: &ReadOptions, talk: &Talk) -> Result<Loaded, Failure> {
    let start = Instant::now();
    let (owned, chosen) = (PathBuf::from(path), options.clone());
    let read = watched(talk, move |progress| read(&owned, &chosen, progress))?;
    let file = read.map_err(|error| with_sample(error, path))?;
    Ok(Loaded::of(file, Vec::new(), start, talk))
}

/// Reads the points and the cells of a file.
pub fn open_mesh(path: &Path, options: &ReadOptions, talk: &Talk) -> Result<(PointFile, CellFile), Failure> {
    let (owned, chosen) = (path.to_owned(), options.clone());
    let read = watched(talk, move |progress| read_mesh(&owned, &chosen, progress))?;
    talk.check();
    let (points, cells) = read?;
    for note in &points.notes {
        talk.note(format!("note: {note}"));
    }
    Ok((points, cells))
}

/// Reads the points of all files of a list.
fn open_list(list: &FileList, options: &ReadOptions, talk: &Talk) -> Result<Loaded, Failure> {
    let start = Instant::now();
    let (owned, chosen) = (list.clone(), options.clone());
    let read = watched(talk, move |progress| read_list(&owned, &chosen, progress))?;
    let PointList { mut content, files } = read?;
    let [points, of] =
        [(content.points.len(), "point"), (files.len(), "file")].map(|(n, noun)| counted(n as u64, noun));
    content.notes.insert(0, format!("read {points} from {of}"));
    Ok(Loaded::of(content, files, start, talk))
}

/// Returns the text of a file that may be compressed.
pub fn text_of(path: &Path, talk: &Talk) -> Result<String, Failure> {
    let owned = path.to_owned();
    let read = move |_: &mut ReadProgress<'_>| {
        let mut text = String::new();
        gzip::open(&owned)?.read_to_string(&mut text)?;
        Ok::<_, std::io::Error>(text)
    };
    watched(talk, read)?.map_err(|error| unreadable(path, &error))
}

/// Returns the name of an input in messages.
pub fn name(path: &Path) -> String {
    if path.as_os_str() == "-" { "standard input".to_owned() } else { path.display().to_string() }
}

/// Returns the failure for a file that cannot be read, worded like the errors of the point readers.
pub fn unreadable(path: &Path, error: &std::io::Error) -> Failure {
    let name = name(path);
    match error.kind() {
        ErrorKind::NotFound => Failure::new(Code::Input, format!("{name}: no such file"))
            .help("check the name and the directory"),
        ErrorKind::IsADirectory => {
            Failure::new(Code::Input, format!("{name}: is a directory")).help("give the name of a file in it")
        }
        _ => Failure::new(Code::Input, format!("{name}: cannot be read: {error}"))
            .help("check the permissions of the file"),
    }
}
