//! Parallel loops, whose bodies are compiled once, and the place where they run.
//!
//! A caller's function is called through a pointer, once for each block of items. The results are in the order of the
//! items, so they do not depend on the number of threads. A generic loop would instantiate the scheduler of rayon for each
//! caller and each kind of point.
//!
//! A loop runs in the pool of its thread, if the thread belongs to one. Otherwise it runs in the pool of the call that
//! [`within`] opened, or in a pool of its own. No loop runs in the global pool of rayon, whose threads a forked process does
//! not have. A pool starts with the first loop that has work for two threads.

use std::any::Any;
use std::cell::{OnceCell, RefCell};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use thiserror::Error;

/// The cores that belong to one worker, if it has more than one.
pub type Pool = Option<Arc<ThreadPool>>;

/// The largest number of blocks into which [`map`] divides a list. Items of shorter lists are blocks of their own.
const MOST_BLOCKS: usize = 1024;

/// The largest number of words that [`sort_rows`] sorts on one thread.
const FEW_WORDS: usize = 1 << 14;

/// Calls a function with every number below a count, in any order.
type Each<'a> = &'a dyn Fn(usize, &(dyn Fn(usize) + Sync));

/// A flag that ends the loops of a call.
type Flag = Option<Arc<AtomicBool>>;

/// The caller of [`within`] ended it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("interrupted")]
pub struct Stopped;

/// The threads of a call.
struct Place {
    threads: usize,
    flag: Flag,
    /// The pool, once a loop needs it. `None` if it cannot start: loops then run on the caller's thread.
    pool: OnceCell<Option<ThreadPool>>,
}

thread_local! {
    static PLACE: RefCell<Option<Rc<Place>>> = const { RefCell::new(None) };
    static FLAG: RefCell<Flag> = const { RefCell::new(None) };
}

impl Place {
    fn new(threads: usize, flag: Flag) -> Self {
        Place { threads, flag, pool: OnceCell::new() }
    }

    /// Returns the place of this thread: that of the call, or a new one.
    fn current() -> Rc<Self> {
        let given = PLACE.with_borrow(Clone::clone);
        given.unwrap_or_else(|| Rc::new(Place::new(outside(), None)))
    }

    /// Returns the pool, or `None` if the call has one thread.
    fn pool(&self) -> Option<&ThreadPool> {
        if self.threads < 2 {
            return None;
        }
        let start = || {
            let flag = self.flag.clone();
            let listener = tracing::dispatcher::get_default(Clone::clone);
            let builder = ThreadPoolBuilder::new().num_threads(self.threads).spawn_handler(move |thread| {
                let (flag, listener) = (flag.clone(), listener.clone());
                let run = move || {
                    FLAG.set(flag);
                    tracing::dispatcher::with_default(&listener, || thread.run());
                };
                std::thread::Builder::new().spawn(run).map(drop)
            });
            builder.build().ok()
        };
        self.pool.get_or_init(start).as_ref()
    }
}

/// The number of threads of loops outside of calls; 0 for the number of cores.
static LIMIT: AtomicUsize = AtomicUsize::new(0);

/// Sets the number of threads of loops that no [`within`] surrounds, on every thread of the process.
pub fn limit(threads: usize) {
    LIMIT.store(threads, Ordering::Relaxed);
}

/// Returns the number of threads of loops that no [`within`] surrounds.
fn outside() -> usize {
    match LIMIT.load(Ordering::Relaxed) {
        0 => cores(),
        threads => threads,
    }
}

/// Restores the place of a thread at the end of a call.
struct Restore(Option<Rc<Place>>, Flag);

impl Drop for Restore {
    fn drop(&mut self) {
        PLACE.set(self.0.take());
        FLAG.set(self.1.take());
    }
}

/// Calls `f` on this thread. The parallel loops of `f` run on `threads` threads, and end between two blocks once `flag` is set.
/// With one thread, they run on this one. Without a flag, that of the surrounding call holds.
///
/// # Errors
/// Returns [`Stopped`] if a loop found the flag set.
///
/// # Panics
/// If `f` panics.
pub fn within<T>(threads: usize, flag: Option<Arc<AtomicBool>>, f: impl FnOnce() -> T) -> Result<T, Stopped> {
    let flag = flag.or_else(|| FLAG.with_borrow(Clone::clone));
    let place = Rc::new(Place::new(threads, flag.clone()));
    let _restore = Restore(PLACE.replace(Some(place)), FLAG.replace(flag));
    catch_unwind(AssertUnwindSafe(f)).map_err(stopped)
}

fn stopped(payload: Box<dyn Any + Send>) -> Stopped {
    payload.downcast::<Stopped>().map_or_else(|other| resume_unwind(other), |stopped| *stopped)
}

/// Ends the call by unwinding if its flag is set.
fn check() {
    if FLAG.with_borrow(|flag| flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))) {
        resume_unwind(Box::new(Stopped));
    }
}

/// Returns the number of cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Calls `f` in a pool: that of this thread, or that of its place. Without one, calls `alone`.
fn pooled<A, T: Send>(state: A, f: impl FnOnce(A) -> T + Send, alone: impl FnOnce(A) -> T) -> T
where
    A: Send,
{
    if rayon::current_thread_index().is_some() {
        return f(state);
    }
    let place = Place::current();
    match place.pool() {
        Some(pool) => pool.install(|| f(state)),
        None => alone(state),
    }
}

/// Calls `f` with every number below `count`, in any order.
pub fn each(count: usize, f: &(dyn Fn(usize) + Sync)) {
    let f = &|at| {
        check();
        f(at);
    };
    let alone = |()| (0..count).for_each(f);
    if count < 2 {
        return alone(());
    }
    pooled((), |()| (0..count).into_par_iter().for_each(f), alone);
}

/// Calls `f` with every number below `count`, on the threads of a pool.
fn each_in(pool: &ThreadPool, count: usize, f: &(dyn Fn(usize) + Sync)) {
    pool.install(|| each(count, f));
}

/// Returns the values of `f` for the blocks of `size` numbers below `len`, in the order of the blocks. The last block may be
/// shorter.
pub fn map_blocks<U: Send>(len: usize, size: usize, f: impl Fn(Range<usize>) -> U + Sync) -> Vec<U> {
    blocks(&each, len, size, f)
}

fn blocks<U: Send>(each: Each<'_>, len: usize, size: usize, f: impl Fn(Range<usize>) -> U + Sync) -> Vec<U> {
    let made: Vec<Mutex<Option<U>>> = (0..len.div_ceil(size)).map(|_| Mutex::new(None)).collect();
    each(made.len(), &|at| {
        let value = f(at * size..len.min((at + 1) * size));
        *made[at].lock().unwrap_or_else(PoisonError::into_inner) = Some(value);
    });
    made.into_iter().filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// Returns the values of `f` for all items, in their order.
pub fn map<T: Sync, U: Send>(items: &[T], f: impl Fn(&T) -> U + Sync) -> Vec<U> {
    items_of(&each, items, f)
}

fn items_of<T: Sync, U: Send>(each: Each<'_>, items: &[T], f: impl Fn(&T) -> U + Sync) -> Vec<U> {
    let size = items.len().div_ceil(MOST_BLOCKS).max(1);
    let made = blocks(each, items.len(), size, |at| items[at].iter().map(&f).collect::<Vec<U>>());
    let mut all = Vec::with_capacity(items.len());
    for block in made {
        all.extend(block);
    }
    all
}

/// Returns the values of `f` for all items, in their order. Uses the worker's own cores if it has any.
pub fn map_in<T: Sync, U: Send>(pool: &Pool, items: &[T], f: impl Fn(&T) -> U + Sync) -> Vec<U> {
    match pool {
        Some(pool) if items.len() > 1 => items_of(&|count, f| each_in(pool, count, f), items, f),
        _ => items.iter().map(f).collect(),
    }
}

/// Calls `f` with every block of `size` items and the number of the block. The last block may be shorter.
pub fn each_chunk_mut<T: Send>(items: &mut [T], size: usize, f: impl Fn(usize, &mut [T]) + Sync) {
    let chunks: Vec<Mutex<&mut [T]>> = items.chunks_mut(size).map(Mutex::new).collect();
    each(chunks.len(), &|at| f(at, &mut chunks[at].lock().unwrap_or_else(PoisonError::into_inner)));
}

/// Calls `f` with every item, in any order.
pub fn each_item<T: Send>(items: Vec<T>, f: impl Fn(T) + Sync) {
    let items: Vec<Mutex<Option<T>>> = items.into_iter().map(|item| Mutex::new(Some(item))).collect();
    each(items.len(), &|at| {
        let item = items[at].lock().unwrap_or_else(PoisonError::into_inner).take();
        item.into_iter().for_each(&f);
    });
}

/// Returns the number of threads of loops on this thread.
pub fn threads() -> usize {
    if rayon::current_thread_index().is_some() {
        rayon::current_num_threads()
    } else {
        PLACE.with_borrow(|place| place.as_ref().map_or_else(outside, |place| place.threads))
    }
}

/// Sorts rows of `width` numbers, from 1 to 9, lexicographically. Numbers beyond the last whole row stay in place.
///
/// # Panics
/// If the width is not between 1 and 9.
pub fn sort_rows(numbers: &mut [u64], width: usize) {
    match width {
        1 => sort(numbers),
        2 => sort(numbers.as_chunks_mut::<2>().0),
        3 => sort(numbers.as_chunks_mut::<3>().0),
        4 => sort(numbers.as_chunks_mut::<4>().0),
        5 => sort(numbers.as_chunks_mut::<5>().0),
        6 => sort(numbers.as_chunks_mut::<6>().0),
        7 => sort(numbers.as_chunks_mut::<7>().0),
        8 => sort(numbers.as_chunks_mut::<8>().0),
        9 => sort(numbers.as_chunks_mut::<9>().0),
        _ => panic!("rows of {width} numbers"),
    }
}

fn sort<T: Ord + Send>(items: &mut [T]) {
    check();
    if size_of_val(items) / size_of::<u64>() <= FEW_WORDS {
        return items.sort_unstable();
    }
    pooled(items, <[T]>::par_sort_unstable, <[T]>::sort_unstable);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists of every length around the number of blocks keep their order, on a pool and without one.
    #[test]
    fn values_are_in_the_order_of_the_items() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().map(Arc::new).ok();
        for len in [0, 1, 2, MOST_BLOCKS - 1, MOST_BLOCKS, MOST_BLOCKS + 1, 5 * MOST_BLOCKS + 7] {
            let items: Vec<usize> = (0..len).collect();
            let expected: Vec<usize> = (0..len).map(|i| i * i).collect();
            assert_eq!(map(&items, |i| i * i), expected);
            assert_eq!(map_in(&pool, &items, |i| i * i), expected);
            assert_eq!(map_in(&None, &items, |i| i * i), expected);
            assert_eq!(map_blocks(len, 10, |at| expected[at].to_vec()).concat(), expected);
            let mut numbers = vec![0; len];
            each_chunk_mut(&mut numbers, 100, |at, chunk| {
                chunk.iter_mut().enumerate().for_each(|(i, number)| *number = (100 * at + i).pow(2));
            });
            assert_eq!(numbers, expected);
            let sum = Mutex::new(0);
            each_item(items, |item| *sum.lock().unwrap() += item);
            assert_eq!(sum.into_inner().unwrap(), len * len.saturating_sub(1) / 2);
        }
    }

    /// Which threads run the loops of a call, if every block waits until two threads have come or a second has passed.
    fn threads_of(threads: usize) -> usize {
        let names = Mutex::new(std::collections::BTreeSet::new());
        let came = || names.lock().unwrap().len();
        let run = || {
            each(16, &|_| {
                names.lock().unwrap().insert(format!("{:?}", std::thread::current().id()));
                for _ in 0..1000 {
                    if came() > 1 || threads == 1 {
                        break;
                    }
                    std::thread::sleep(std::time::Duration::from_millis(1));
                }
            });
        };
        within(threads, None, run).unwrap();
        came()
    }

    #[test]
    fn loops_run_on_the_threads_of_their_call() {
        assert_eq!(threads_of(1), 1);
        assert!((2..=3).contains(&threads_of(3)));
        assert_eq!(within(5, None, threads), Ok(5));
        assert_eq!(within(5, None, || within(2, None, threads)), Ok(Ok(2)));
        assert_eq!(threads(), cores());
    }

    #[test]
    fn a_flag_ends_the_loops_of_its_call() {
        for threads in [1, 3] {
            let flag = Arc::new(AtomicBool::new(false));
            let run =
                || each(1000, &|at| flag.store(at == 7 || flag.load(Ordering::Relaxed), Ordering::Relaxed));
            assert_eq!(within(threads, Some(flag.clone()), run), Err(Stopped));
            assert_eq!(within(threads, Some(flag.clone()), || sort_rows(&mut [2, 1], 1)), Err(Stopped));
            // The flag is that of the call, and not of the thread.
            each(2, &|_| {});
            let inner = || within(1, None, || each(2, &|_| {}));
            assert_eq!((inner(), within(threads, Some(flag), inner)), (Ok(()), Ok(Err(Stopped))));
        }
    }

    #[test]
    fn a_panic_leaves_the_call() {
        let panicked = catch_unwind(|| within(2, None, || each(2, &|at| assert!(at < 1))));
        assert!(panicked.is_err());
        assert_eq!(threads(), cores());
    }

    #[test]
    fn rows_are_sorted_by_all_their_numbers() {
        for (width, rows) in (1..=9).flat_map(|width| [(width, 60), (width, 20_000)]) {
            let mut numbers: Vec<u64> = (0..rows * width as u64).map(|i| i * 7919 % 4).collect();
            let mut expected: Vec<Vec<u64>> = numbers.chunks(width).map(<[u64]>::to_vec).collect();
            expected.sort();
            sort_rows(&mut numbers, width);
            assert_eq!(numbers, expected.concat());
        }
    }
}
