//! Parallel loops, whose bodies are compiled once.
//!
//! A caller's function is called through a pointer, once for each block of items. The results are in the order of the
//! items, so they do not depend on the number of threads. A generic loop would instantiate the scheduler of rayon for each
//! caller and each kind of point.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::ThreadPool;
use rayon::prelude::*;

/// The cores that belong to one worker, if it has more than one.
pub type Pool = Option<Arc<ThreadPool>>;

/// The largest number of blocks into which [`map`] divides a list. Items of shorter lists are blocks of their own.
const MOST_BLOCKS: usize = 1024;

/// Calls a function with every number below a count, in any order.
type Each<'a> = &'a dyn Fn(usize, &(dyn Fn(usize) + Sync));

/// Calls `f` with every number below `count`, on the threads of the current pool and in any order.
pub fn each(count: usize, f: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(f);
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

/// Returns the number of threads of the current pool.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// Sorts rows of `width` numbers, from 1 to 8, lexicographically. Numbers beyond the last whole row stay in place.
///
/// # Panics
/// If the width is not between 1 and 8.
pub fn sort_rows(numbers: &mut [u64], width: usize) {
    match width {
        1 => numbers.par_sort_unstable(),
        2 => numbers.as_chunks_mut::<2>().0.par_sort_unstable(),
        3 => numbers.as_chunks_mut::<3>().0.par_sort_unstable(),
        4 => numbers.as_chunks_mut::<4>().0.par_sort_unstable(),
        5 => numbers.as_chunks_mut::<5>().0.par_sort_unstable(),
        6 => numbers.as_chunks_mut::<6>().0.par_sort_unstable(),
        7 => numbers.as_chunks_mut::<7>().0.par_sort_unstable(),
        8 => numbers.as_chunks_mut::<8>().0.par_sort_unstable(),
        9 => numbers.as_chunks_mut::<9>().0.par_sort_unstable(),
        _ => panic!("rows of {width} numbers"),
    }
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

    #[test]
    fn rows_are_sorted_by_all_their_numbers() {
        for width in 1..=7 {
            let mut numbers: Vec<u64> = (0..60 * width as u64).map(|i| i * 7919 % 4).collect();
            let mut expected: Vec<Vec<u64>> = numbers.chunks(width).map(<[u64]>::to_vec).collect();
            expected.sort();
            sort_rows(&mut numbers, width);
            assert_eq!(numbers, expected.concat());
        }
    }
}
