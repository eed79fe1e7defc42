//! The exported functions. The only module with `unsafe`: it turns pointers of callers into slices and references.
//!
//! `include/septet.h` says what each function does, and what its caller promises.
#![allow(unsafe_code, reason = "pointers of callers")]

use std::ffi::c_char;
use std::mem::{offset_of, size_of};
use std::ptr::null;
use std::sync::atomic::AtomicI32;

use septet_doors::{Failure, check_columns};

use crate::handle::{self, Handle, call, method, narrow, wide};
use crate::last::{last, status, value};

/// The version of the interface.
const ABI: u32 = 1;

/// Options, as in `septet.h`.
#[repr(C)]
#[derive(Debug)]
pub struct Options {
    /// The size of the structure that the caller knows, in bytes.
    pub size: usize,
    /// Number of threads; 0 for all cores.
    pub threads: u32,
    /// Whether points that are not finite are dropped: 0 or 1.
    pub skip_invalid: u32,
    /// Seed of the random draws.
    pub seed: u64,
    /// The most memory, in bytes; 0 for no limit.
    pub max_memory: u64,
    /// A number that ends the call when it is not 0, or NULL.
    pub cancel: *const i32,
    /// The weight of each point, or NULL.
    pub weights: *const f64,
    /// The length of a periodic box along each axis, 0 along an axis that is not periodic; or NULL.
    pub period: *const f64,
    /// The lower corner of the periodic box, or NULL for 0.
    pub origin: *const f64,
    /// Whether points outside of the periodic box are admitted: 0 or 1.
    pub wrap: u32,
    /// 0.
    pub reserved: u32,
}

impl Options {
    fn of(options: &handle::Options<'_>) -> Self {
        let handle::Options { threads, skip_invalid, seed, max_memory, .. } = *options;
        Options {
            size: size_of::<Options>(),
            threads,
            skip_invalid,
            seed,
            max_memory,
            cancel: null(),
            weights: null(),
            period: null(),
            origin: null(),
            wrap: 0,
            reserved: 0,
        }
    }

    /// Reads the fields that the caller knows, for `n` points of a dimension.
    ///
    /// # Safety
    /// The pointer is NULL, or valid for reads of as many bytes as its first field says. The field `cancel` is NULL, or valid for
    /// atomic reads while the result lives. The field `weights` is NULL, or valid for reads of `n` numbers while the result lives;
    /// `period` and `origin` are NULL, or valid for reads of as many numbers as the dimension.
    unsafe fn read<'a>(
        at: *const Options,
        n: usize,
        dimension: usize,
    ) -> Result<handle::Options<'a>, Failure> {
        let mut options = handle::Options::default();
        if at.is_null() {
            return Ok(options);
        }
        aligned(at, "options")?;
        // SAFETY: the caller set the size.
        let size = unsafe { (&raw const (*at).size).read() };
        if size < size_of::<usize>() || size > size_of::<Options>() {
            return Err(Failure::usage(format!(
                "the size of the options is {size}, but this library knows up to {}; call septet_options_init, and use \
                 the header of this library",
                size_of::<Options>()
            )));
        }
        macro_rules! field {
            ($name:ident: $type:ty) => {
                if offset_of!(Options, $name) + size_of::<$type>() <= size {
                    // SAFETY: the field lies within the size.
                    Some(unsafe { (&raw const (*at).$name).read() })
                } else {
                    None
                }
            };
        }
        options.threads = field!(threads: u32).unwrap_or(options.threads);
        options.skip_invalid = field!(skip_invalid: u32).unwrap_or(options.skip_invalid);
        options.seed = field!(seed: u64).unwrap_or(options.seed);
        options.max_memory = field!(max_memory: u64).unwrap_or(options.max_memory);
        if let Some(cancel) = field!(cancel: *const i32).filter(|cancel| !cancel.is_null()) {
            aligned(cancel, "cancel")?;
            // SAFETY: the caller promises it. The number is only read.
            options.cancel = Some(unsafe { AtomicI32::from_ptr(cancel.cast_mut()) });
        }
        let array = |at: Option<*const f64>, count: usize, name: &str| {
            let at = at.filter(|at| !at.is_null());
            // SAFETY: the caller promises it.
            at.map(|at| unsafe { slice(at, entries(count, 1, name)?, name) }).transpose()
        };
        options.weights = array(field!(weights: *const f64), n, "weights")?;
        options.period = array(field!(period: *const f64), dimension, "period")?;
        options.origin = array(field!(origin: *const f64), dimension, "origin")?;
        options.wrap = field!(wrap: u32).unwrap_or(options.wrap);
        match field!(reserved: u32).unwrap_or(0) {
            0 => Ok(options),
            other => Err(Failure::usage(format!("reserved is {other}: pass 0"))),
        }
    }
}

fn is_null(name: &str) -> Failure {
    Failure::usage(format!("{name} is NULL; pass a valid pointer"))
}

/// Checks that a pointer can be read.
fn aligned<T>(at: *const T, name: &str) -> Result<(), Failure> {
    if at.is_null() {
        return Err(is_null(name));
    }
    if !at.is_aligned() {
        return Err(Failure::usage(format!("{name} is not aligned to {} bytes", align_of::<T>())));
    }
    Ok(())
}

/// Returns the number of entries of `rows` rows, if they fit into memory.
fn entries(rows: usize, columns: usize, name: &str) -> Result<usize, Failure> {
    let count = rows.checked_mul(columns).filter(|&count| count <= isize::MAX as usize / size_of::<f64>());
    count.ok_or_else(|| {
        Failure::usage(format!("{name} has {rows} rows of {columns} numbers, more than memory holds"))
    })
}

/// # Safety
/// The pointer is NULL, or valid for reads of `count` numbers while the result lives.
unsafe fn slice<'a>(at: *const f64, count: usize, name: &str) -> Result<&'a [f64], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    aligned(at, name)?;
    // SAFETY: the caller promises it.
    Ok(unsafe { std::slice::from_raw_parts(at, count) })
}

/// Copies values into an array of the caller.
///
/// # Safety
/// The pointer is NULL, or valid for writes of the number of values.
unsafe fn copy_out<T>(values: impl ExactSizeIterator<Item = T>, out: *mut T) -> Result<(), Failure> {
    if values.len() == 0 {
        return Ok(());
    }
    aligned(out.cast_const(), "out")?;
    for (at, value) in values.enumerate() {
        // SAFETY: the position is below the number of values.
        unsafe { out.add(at).write(value) };
    }
    Ok(())
}

/// # Safety
/// NULL, or a triangulation that has not been freed.
unsafe fn live<'a>(t: *const Handle) -> Result<&'a Handle, Failure> {
    aligned(t, "the triangulation")?;
    // SAFETY: the caller promises it.
    unsafe { t.as_ref() }.ok_or_else(|| is_null("the triangulation"))
}

/// # Safety
/// NULL, or a triangulation that has not been freed.
unsafe fn count<T>(t: *const Handle, missing: T, of: impl FnOnce(&Handle) -> T) -> T
where
    T: Copy,
{
    // SAFETY: the caller promises it.
    value(missing, || unsafe { live(t) }.map_or(missing, of))
}

/// Returns the version of the library.
#[unsafe(no_mangle)]
pub extern "C" fn septet_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Returns the version of the interface.
#[unsafe(no_mangle)]
pub extern "C" fn septet_abi() -> u32 {
    ABI
}

/// Returns the text of the last failure of this thread.
#[unsafe(no_mangle)]
pub extern "C" fn septet_last_error() -> *const c_char {
    value(c"".as_ptr(), || last(|text, _| text.as_ptr()))
}

/// Returns the row of the point of the last failure, or -1.
#[unsafe(no_mangle)]
pub extern "C" fn septet_last_index() -> i64 {
    value(-1, || last(|_, index| index))
}

/// Sets the options up to `cancel` to their defaults: those of programs that were built when there were no others.
///
/// # Safety
/// See `septet.h`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn septet_options_init(options: *mut Options) {
    // SAFETY: the caller promises it.
    unsafe { septet_options_init_sized(options, offset_of!(Options, weights)) };
}

/// Sets the options within a size to their defaults.
///
/// # Safety
/// See `septet.h`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn septet_options_init_sized(options: *mut Options, size: usize) {
    let size = size.min(size_of::<Options>());
    if aligned(options.cast_const(), "options").is_ok() && size >= size_of::<usize>() {
        let defaults = Options { size, ..Options::of(&handle::Options::default()) };
        // SAFETY: the caller promises it. The structure has no gaps.
        unsafe { (&raw const defaults).cast::<u8>().copy_to_nonoverlapping(options.cast::<u8>(), size) };
    }
}

/// Triangulates points.
///
/// # Safety
/// See `septet.h`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn septet_triangulate(
    points: *const f64,
    n: usize,
    dimension: u32,
    options: *const Options,
    out: *mut *mut Handle,
) -> i32 {
    status(|| {
        aligned(out.cast_const(), "out")?;
        // The options have as many numbers of a box as a point has.
        check_columns(dimension as usize)?;
        // SAFETY: the caller promises it.
        let (points, options) = unsafe {
            (
                slice(points, entries(n, dimension as usize, "points")?, "points")?,
                Options::read(options, n, dimension as usize)?,
            )
        };
        let made = Box::new(Handle::new(points, dimension, &options)?);
        // SAFETY: the caller promises it.
        unsafe { out.write(Box::into_raw(made)) };
        Ok(())
    })
}

/// Frees a triangulation.
///
/// # Safety
/// See `septet.h`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn septet_free(t: *mut Handle) {
    if !t.is_null() {
        // SAFETY: the caller promises it.
        value((), || drop(unsafe { Box::from_raw(t) }));
    }
}

/// Functions that return a number of a triangulation, or 0 for NULL.
macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident(|$t:ident| $value:expr) -> $type:ty;)*) => {$(
        $(#[$doc])*
        ///
        /// # Safety
        /// See `septet.h`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(t: *const Handle) -> $type {
            // SAFETY: the caller promises it.
            unsafe { count(t, 0, |$t| $value) }
        }
    )*};
}

numbers! {
    /// Returns the number of coordinates of a point.
    septet_dimension(|t| t.made.columns() as u32) -> u32;
    /// Returns the dimension of the affine hull of the points.
    septet_rank(|t| t.made.dimension() as i32) -> i32;
    /// Returns the number of points.
    septet_points_count(|t| t.made.len()) -> usize;
    /// Returns the number of cells.
    septet_cells_count(|t| t.made.cell_count()) -> usize;
    /// Returns the number of facets of the hull.
    septet_hull_count(|t| t.hull().map_or(0, <[u32]>::len) / t.made.columns()) -> usize;
    /// Returns the number of coincident points.
    septet_duplicates_count(|t| t.made.duplicates().len() / 2) -> usize;
    /// Returns the number of points that weights hide.
    septet_hidden_count(|t| t.made.hidden().len()) -> usize;
    /// Whether the cells are a simplicial complex.
    septet_is_simplicial(|t| i32::from(t.made.is_simplicial())) -> i32;
}

/// Functions that copy an array of a triangulation.
macro_rules! copies {
    ($($(#[$doc:meta])* $name:ident(|$t:ident| $values:expr) -> $type:ty;)*) => {$(
        $(#[$doc])*
        ///
        /// # Safety
        /// See `septet.h`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(t: *const Handle, out: *mut $type) -> i32 {
            status(|| {
                // SAFETY: the caller promises it.
                let $t = unsafe { live(t) }?;
                // SAFETY: the caller promises it.
                unsafe { copy_out($values, out) }
            })
        }
    )*};
}

copies! {
    /// Copies the cells.
    septet_cells_i32(|t| narrow(t.made.cells())?) -> i32;
    /// Copies the cells.
    septet_cells_i64(|t| wide(t.made.cells())) -> i64;
    /// Copies the neighbours.
    septet_neighbors_i32(|t| narrow(t.made.neighbours())?) -> i32;
    /// Copies the neighbours.
    septet_neighbors_i64(|t| wide(t.made.neighbours())) -> i64;
    /// Copies the facets of the hull.
    septet_hull(|t| wide(t.hull()?)) -> i64;
    /// Copies the first cell of each point.
    septet_vertex_to_cell(|t| wide(&t.made.vertex_cells())) -> i64;
    /// Copies the coincident points.
    septet_duplicates(|t| wide(t.made.duplicates())) -> i64;
    /// Copies the points that weights hide.
    septet_hidden(|t| wide(t.made.hidden())) -> i64;
    /// Copies the offsets of the vertices of the cells.
    septet_offsets(|t| t.offsets()?.iter().copied()) -> i32;
    /// Copies the numbers of boxes whose triangulation is a simplicial complex.
    septet_sheets(|t| t.sheets()?.iter().copied()) -> u32;
}

/// Locates queries.
///
/// # Safety
/// See `septet.h`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn septet_locate(
    t: *const Handle,
    x: *const f64,
    n: usize,
    threads: u32,
    out: *mut i64,
) -> i32 {
    // SAFETY: the caller promises it.
    status(|| unsafe {
        let made = &live(t)?.made;
        let x = slice(x, entries(n, made.columns(), "x")?, "x")?;
        copy_out(wide(&made.locate(x, &call(threads)?)?), out)
    })
}

/// Finds the nearest vertices of queries.
///
/// # Safety
/// See `septet.h`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn septet_nearest(
    t: *const Handle,
    x: *const f64,
    n: usize,
    threads: u32,
    out: *mut i64,
) -> i32 {
    // SAFETY: the caller promises it.
    status(|| unsafe {
        let made = &live(t)?.made;
        let x = slice(x, entries(n, made.columns(), "x")?, "x")?;
        copy_out(wide(&made.nearest(x, &call(threads)?)?), out)
    })
}

/// Interpolates values at queries.
///
/// # Safety
/// See `septet.h`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn septet_interpolate(
    t: *const Handle,
    values: *const f64,
    columns: usize,
    x: *const f64,
    n: usize,
    number: i32,
    outside: f64,
    threads: u32,
    out: *mut f64,
) -> i32 {
    // SAFETY: the caller promises it.
    status(|| unsafe {
        let made = &live(t)?.made;
        let values = slice(values, entries(made.len(), columns, "values")?, "values")?;
        let x = slice(x, entries(n, made.columns(), "x")?, "x")?;
        entries(n, columns, "out")?;
        let how = (method(number)?, outside);
        copy_out(made.interpolate((values, columns), x, how, &call(threads)?)?.into_iter(), out)
    })
}

/// Measures the Voronoi cells.
///
/// # Safety
/// See `septet.h`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn septet_voronoi_volumes(
    t: *const Handle,
    low: *const f64,
    high: *const f64,
    threads: u32,
    out: *mut f64,
) -> i32 {
    // SAFETY: the caller promises it.
    status(|| unsafe {
        let made = &live(t)?.made;
        let corners = if low.is_null() && high.is_null() {
            None
        } else {
            Some((slice(low, made.columns(), "low")?, slice(high, made.columns(), "high")?))
        };
        copy_out(made.voronoi_volumes(corners, &call(threads)?)?.into_iter(), out)
    })
}

/// Copies the squared radii of the cells.
///
/// # Safety
/// See `septet.h`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn septet_alpha(t: *const Handle, out: *mut f64) -> i32 {
    // SAFETY: the caller promises it.
    status(|| unsafe { copy_out(live(t)?.made.alpha_values(&call(0)?)?.into_iter(), out) })
}
