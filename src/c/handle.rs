//! The options of a triangulation, and the triangulation behind a handle of a caller.

use std::sync::OnceLock;
use std::sync::atomic::AtomicI32;

use septet_doors::{Call, Door, Failure, Method, NONE, Periodic, Request, Sites, Triangulated};

use crate::watch::watched;

/// The largest number of threads.
const MOST_THREADS: u32 = 4096;

/// A triangulation of a caller: `septet_triangulation`.
#[derive(Debug)]
pub struct Handle {
    /// The triangulation.
    pub(crate) made: Triangulated,
    /// The facets of the hull, once requested.
    hull: OnceLock<Vec<u32>>,
}

/// The options of a triangulation, checked by size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options<'a> {
    pub(crate) threads: u32,
    pub(crate) skip_invalid: u32,
    pub(crate) seed: u64,
    pub(crate) max_memory: u64,
    pub(crate) cancel: Option<&'a AtomicI32>,
    pub(crate) weights: Option<&'a [f64]>,
    pub(crate) period: Option<&'a [f64]>,
    pub(crate) origin: Option<&'a [f64]>,
    pub(crate) wrap: u32,
}

impl Default for Options<'_> {
    fn default() -> Self {
        let Request { seed, .. } = Request::new(Call::new(Door::C));
        Options {
            threads: 0,
            skip_invalid: 0,
            seed,
            max_memory: 0,
            cancel: None,
            weights: None,
            period: None,
            origin: None,
            wrap: 0,
        }
    }
}

impl Options<'_> {
    /// Returns the weights and the periodic box.
    ///
    /// # Errors
    /// Fails if there is a corner without a box, or if a flag is neither 0 nor 1.
    fn sites(&self) -> Result<Sites, Failure> {
        if self.wrap > 1 {
            return Err(Failure::usage(format!("wrap is {}: pass 0 or 1", self.wrap)));
        }
        if self.period.is_none() && (self.origin.is_some() || self.wrap == 1) {
            return Err(Failure::usage("origin and wrap need a periodic box; set period, or clear them"));
        }
        let length = |&length: &f64| (length != 0.0).then_some(length);
        let periodic = self.period.map(|lengths| {
            let mut periodic = Periodic::of(lengths.iter().map(length).collect());
            periodic.origin = self.origin.unwrap_or_default().to_vec();
            periodic.wrap = self.wrap == 1;
            periodic
        });
        Ok(Sites { weights: self.weights.map(<[f64]>::to_vec), periodic })
    }
}

/// Returns a call on a number of threads.
///
/// # Errors
/// Fails if there are too many.
pub(crate) fn call(threads: u32) -> Result<Call, Failure> {
    if threads > MOST_THREADS {
        return Err(Failure::usage(format!(
            "threads is {threads}: pass 0 for all cores, or at most {MOST_THREADS}"
        )));
    }
    Ok(Call::new(Door::C).threads(threads as usize))
}

/// Returns a method of interpolation by its number in the header.
///
/// # Errors
/// Fails if there is no such method.
pub(crate) fn method(number: i32) -> Result<Method, Failure> {
    match number {
        0 => Ok(Method::Linear),
        1 => Ok(Method::Sibson),
        2 => Ok(Method::Laplace),
        _ => Err(Failure::usage(format!(
            "method is {number}: pass SEPTET_LINEAR, SEPTET_SIBSON or SEPTET_LAPLACE"
        ))),
    }
}

fn no_box(what: &str) -> Failure {
    Failure::usage(format!("there are no {what} without a periodic box; set period in septet_options"))
}

/// Converts indices to 64 bits; [`NONE`] becomes -1.
pub(crate) fn wide(indices: &[u32]) -> impl ExactSizeIterator<Item = i64> {
    indices.iter().map(|&index| if index == NONE { -1 } else { i64::from(index) })
}

/// Converts indices to 32 bits; [`NONE`] becomes -1.
///
/// # Errors
/// Fails if an index does not fit.
pub(crate) fn narrow(indices: &[u32]) -> Result<impl ExactSizeIterator<Item = i32>, Failure> {
    let fits = |&index: &u32| index == NONE || i32::try_from(index).is_ok();
    if let Some(index) = indices.iter().find(|index| !fits(index)) {
        let message = format!("index {index} does not fit into 32 bits; call the function for 64 bits");
        return Err(Failure::new(septet_doors::Code::Limit, message));
    }
    Ok(indices.iter().map(|&index| index as i32))
}

impl Handle {
    /// Triangulates rows of points.
    ///
    /// # Errors
    /// See [`Triangulated::new`].
    pub(crate) fn new(points: &[f64], dimension: u32, options: &Options<'_>) -> Result<Self, Failure> {
        let Options { threads, skip_invalid, seed, max_memory, cancel, .. } = *options;
        if skip_invalid > 1 {
            return Err(Failure::usage(format!("skip_invalid is {skip_invalid}: pass 0 or 1")));
        }
        let (call, sites) = (call(threads)?, options.sites()?);
        let made = watched(cancel, |flag| {
            let mut request = Request::new(call);
            request.call.cancel = flag;
            request.skip_invalid = skip_invalid == 1;
            request.seed = seed;
            request.sites = sites;
            request.max_memory = (max_memory > 0).then_some(max_memory);
            Triangulated::new(points, dimension as usize, &request)
        })?;
        Ok(Handle { made, hull: OnceLock::new() })
    }

    /// Returns the offsets of the vertices of the cells.
    ///
    /// # Errors
    /// Fails without a periodic box.
    pub(crate) fn offsets(&self) -> Result<&[i32], Failure> {
        self.made.offsets().ok_or_else(|| no_box("offsets"))
    }

    /// Returns the numbers of boxes whose triangulation is a simplicial complex.
    ///
    /// # Errors
    /// Fails without a periodic box.
    pub(crate) fn sheets(&self) -> Result<&[u32], Failure> {
        self.made.sheets().ok_or_else(|| no_box("sheets"))
    }

    /// Returns the facets of the hull, one after the other.
    ///
    /// # Errors
    /// See [`Triangulated::hull`].
    pub(crate) fn hull(&self) -> Result<&[u32], Failure> {
        if let Some(hull) = self.hull.get() {
            return Ok(hull);
        }
        let hull = self.made.hull(&Call::new(Door::C))?;
        Ok(self.hull.get_or_init(|| hull))
    }
}
