//! Loops over lanes, compiled for several register widths and dispatched to the widest available one.
//!
//! **Statement.** The instructions differ, but the results do not. Each lane performs the same additions, subtractions,
//! products and comparisons in the same order and precision, with the same rounding (IEEE 754). Products and additions
//! are never fused, because the compiler fuses them only on request.
//!
//! The instruction set is detected once, at the first use. On x86-64 it is the baseline, AVX2 or AVX-512.

#![expect(clippy::needless_bitwise_bool, reason = "a fold without branches becomes vector instructions")]
#![expect(clippy::inline_always, reason = "functions that are not inlined do not use the widest registers")]

use std::sync::atomic::{AtomicBool, Ordering};

use pulp::Arch;
#[cfg(target_arch = "x86_64")]
use pulp::{cast, x86::V4};

static BASELINE: AtomicBool = AtomicBool::new(false);

/// Restricts this process from now on to the registers of the baseline instruction set. Results do not change. Use this
/// function for comparisons, and for instruction counts that do not depend on the machine.
pub fn use_baseline_registers() {
    BASELINE.store(true, Ordering::Relaxed);
}

/// Runs `f` compiled for the widest available registers. `f` and the functions that it calls benefit only if they are
/// inlined, so all of them should be `#[inline(always)]`.
#[inline]
pub(crate) fn widest<R>(f: impl FnOnce() -> R) -> R {
    if BASELINE.load(Ordering::Relaxed) { f() } else { Arch::new().dispatch(f) }
}

/// Returns the larger of two numbers, or the second if one is NaN. It compiles to one instruction.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The numbers above `above` and at most `limit`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub(crate) above: f64,
    pub(crate) limit: f64,
}

/// Eight numbers, each with a name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NamedLanes<'a> {
    pub(crate) numbers: &'a [f64; 8],
    pub(crate) names: &'a [u32; 8],
}

/// Room for eight numbers and their names.
#[derive(Debug)]
pub(crate) struct NamedLanesMut<'a> {
    pub(crate) numbers: &'a mut [f64; 8],
    pub(crate) names: &'a mut [u32; 8],
}

/// Operations on eight lanes with bit masks. AVX-512 has instructions for them; other instruction sets use loops.
/// Create it once before a loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Masks {
    #[cfg(target_arch = "x86_64")]
    v4: Option<V4>,
}

impl Default for Masks {
    /// Uses AVX-512 if available, unless [`use_baseline_registers`] was called.
    fn default() -> Self {
        Masks {
            #[cfg(target_arch = "x86_64")]
            v4: if BASELINE.load(Ordering::Relaxed) { None } else { V4::try_new() },
        }
    }
}

impl Masks {
    /// Returns the operations with the available instructions, and with loops.
    #[cfg(test)]
    pub(crate) fn both() -> [Self; 2] {
        let loops = Masks {
            #[cfg(target_arch = "x86_64")]
            v4: None,
        };
        [Masks::default(), loops]
    }

    /// Returns the lanes that are at most `limit`, as a bit mask.
    #[inline(always)]
    pub(crate) fn at_most(self, lanes: &[f64; 8], limit: f64) -> u32 {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = self.v4 {
            return u32::from(v4.cmp_le_f64x8(cast(*lanes), cast([limit; 8])).0);
        }
        at_most(lanes, limit)
    }

    /// Returns the lanes that are not below their limits, as a bit mask.
    #[inline(always)]
    pub(crate) fn not_below(self, lanes: &[f32; 8], limits: &[f32; 8]) -> u32 {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = self.v4 {
            return u32::from(!v4.cmp_lt_f32x8(cast(*lanes), cast(*limits)).0);
        }
        let clear = lanes.iter().zip(limits).fold(true, |all, (lane, limit)| all & (lane < limit));
        if clear { 0 } else { not_below(lanes, limits) }
    }

    /// Sorts distinct numbers in the storage that holds them. If [`Masks::can_count`] and there are at most 96 numbers,
    /// it counts, for each number, the smaller ones. Otherwise it uses a comparison sort.
    pub(crate) fn sorted(self, numbers: &mut Vec<u64>) -> &[u64] {
        let len = numbers.len();
        if !self.can_count() || len > 96 {
            numbers.sort_unstable();
            return numbers;
        }
        let room = len.next_multiple_of(8);
        numbers.resize(room + len, u64::MAX);
        let (given, sorted) = numbers.split_at_mut(room);
        widest(
            #[inline(always)]
            || by_counting(given, sorted),
        );
        sorted
    }

    /// Returns `true` if one instruction compares eight numbers, so that counting smaller numbers is fast.
    pub(crate) fn can_count(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        let can = self.v4.is_some();
        #[cfg(not(target_arch = "x86_64"))]
        let can = false;
        can
    }

    /// Moves the wanted numbers and their names to the front of `to`. The other entries are unspecified. Returns how
    /// many were moved.
    #[inline(always)]
    pub(crate) fn pack(self, from: NamedLanes<'_>, wanted: Interval, to: NamedLanesMut<'_>) -> usize {
        #[cfg(target_arch = "x86_64")]
        if let Some(v4) = self.v4 {
            let NamedLanesMut { numbers, names } = to;
            let bits = self.at_most(from.numbers, wanted.limit) & !self.at_most(from.numbers, wanted.above);
            *numbers = cast(v4.avx512f._mm512_maskz_compress_pd(bits as u8, cast(*from.numbers)));
            // Only the lower half is used.
            let packed = v4.avx512f._mm512_maskz_compress_epi32(bits as u16, cast([*from.names; 2]));
            *names = cast::<_, [[u32; 8]; 2]>(packed)[0];
            return bits.count_ones() as usize;
        }
        pack(from, wanted, to)
    }
}

/// Implements [`Masks::pack`] by a loop. Instead of branching, it writes each number and advances only if the number
/// is wanted. The function is not inlined, for the reason given at [`at_most`].
#[inline(never)]
fn pack(from: NamedLanes<'_>, wanted: Interval, to: NamedLanesMut<'_>) -> usize {
    let NamedLanesMut { numbers, names } = to;
    let mut count = 0;
    for lane in 0..8 {
        let number = from.numbers[lane];
        numbers[count & 7] = number;
        names[count & 7] = from.names[lane];
        count += usize::from((number <= wanted.limit) & (number > wanted.above));
    }
    count
}

/// Returns the lanes that are at most `limit`, as a bit mask. The function is not inlined: inside the loop that
/// computes the lanes, it would make the compiler process the lanes as eight scalars.
#[inline(never)]
fn at_most(lanes: &[f64; 8], limit: f64) -> u32 {
    let bits: [u64; 8] = std::array::from_fn(|lane| if lanes[lane] <= limit { 1 << lane } else { 0 });
    bits.iter().fold(0, |all, bit| all | bit) as u32
}

/// Returns the lanes that are not below their limits, as a bit mask. The function is not inlined, for the reason
/// given at [`at_most`].
#[inline(never)]
fn not_below(lanes: &[f32; 8], limits: &[f32; 8]) -> u32 {
    let bits: [u32; 8] = std::array::from_fn(|lane| if lanes[lane] < limits[lane] { 0 } else { 1 << lane });
    bits.iter().fold(0, |all, bit| all | bit)
}

/// Sorts distinct numbers by counting. The first `sorted.len()` entries of `given` are the numbers; the others are
/// padding up to a multiple of eight.
#[inline(always)]
fn by_counting(given: &[u64], sorted: &mut [u64]) {
    for (at, block) in given.as_chunks::<8>().0.iter().enumerate() {
        let mut smaller = [0u64; 8];
        for &other in &given[..sorted.len()] {
            for (count, &number) in smaller.iter_mut().zip(block) {
                *count = count.wrapping_add(u64::from(other < number));
            }
        }
        for (&number, &rank) in block.iter().zip(&smaller).take(sorted.len() - 8 * at) {
            sorted[rank as usize] = number;
        }
    }
}

/// Iterates over the positions of the bits that are set, in ascending order.
#[inline(always)]
pub(crate) fn each_bit(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = (bits != 0).then(|| bits.trailing_zeros() as usize);
            bits &= bits.wrapping_sub(1);
            lane
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of products whose last bits reveal a fused operation.
    #[inline(always)]
    fn products(x: &[f64], y: &[f64], z: &[f64]) -> Vec<u64> {
        x.iter().zip(y).zip(z).map(|((x, y), z)| (x * x + y * y + z * z - x * y).to_bits()).collect()
    }

    #[inline(always)]
    fn single_products(x: &[f32], y: &[f32]) -> Vec<u32> {
        x.iter().zip(y).map(|(x, y)| (x * x + y * y - x * y).to_bits()).collect()
    }

    #[test]
    fn masks_select_lanes() {
        for lanes in Masks::both() {
            let selected = |bits: u32| each_bit(u64::from(bits)).collect::<Vec<_>>();
            let x = [0.0, 2.0, -1.0, f64::NAN, 1.0, f64::INFINITY, 1.5, -0.0];
            assert_eq!(selected(lanes.at_most(&x, 1.0)), [0, 2, 4, 7]);
            assert_eq!(selected(lanes.at_most(&x, f64::INFINITY)), [0, 1, 2, 4, 5, 6, 7]);
            assert_eq!(selected(lanes.at_most(&x, f64::NAN)), []);
            let limits = [0.0, 3.0, -1.0, 0.0, f32::NAN, 1.0, f32::INFINITY, 1.0];
            assert_eq!(selected(lanes.not_below(&x.map(|x| x as f32), &limits)), [0, 2, 3, 4, 5]);
        }
        assert_eq!(each_bit(0).count(), 0);
        assert_eq!(each_bit(u64::MAX).collect::<Vec<_>>(), (0..64).collect::<Vec<_>>());
    }

    #[test]
    fn short_lists_are_sorted() {
        for masks in Masks::both() {
            for len in (0..40).chain([63, 64, 65, 95, 96, 97, 200]) {
                let number = |i: u64| if i & 1 == 0 { i } else { i.wrapping_mul(0x9E37_79B9_7F4A_7C15) };
                let mut numbers: Vec<u64> = (0..len).map(number).collect();
                let mut sorted = numbers.clone();
                sorted.sort_unstable();
                let (mut given, mut counted) = (numbers.clone(), vec![0; sorted.len()]);
                given.resize(given.len().next_multiple_of(8), u64::MAX);
                by_counting(&given, &mut counted);
                assert_eq!(counted, sorted, "{len}");
                assert_eq!(masks.sorted(&mut numbers), sorted, "{len}");
            }
            let mut ends = vec![u64::MAX, 0, 1 << 63, u64::MAX - 1, 1];
            assert_eq!(masks.sorted(&mut ends), [0, 1, 1 << 63, u64::MAX - 1, u64::MAX]);
        }
    }

    #[test]
    fn lanes_are_packed_between_limits() {
        let names: [u32; 8] = std::array::from_fn(|lane| 1 << 31 | lane as u32);
        let edges = [-1.0, 0.0, 1.5, 3.0, f64::INFINITY];
        for masks in Masks::both() {
            for wanted in 0..256 {
                for (above, limit) in edges.windows(2).map(|edges| (edges[0], edges[1])) {
                    // Wanted lanes are at the upper limit. The others are at the lower limit, beyond a limit, or NaN.
                    let numbers = std::array::from_fn(|lane| {
                        let beyond = if limit.is_finite() { limit.next_up() } else { f64::NAN };
                        let others = [above, beyond, f64::NAN, above - 1.0];
                        if wanted >> lane & 1 != 0 { limit } else { others[lane % 4] }
                    });
                    let mut packed = ([0.0; 8], [0; 8]);
                    let from = NamedLanes { numbers: &numbers, names: &names };
                    let to = NamedLanesMut { numbers: &mut packed.0, names: &mut packed.1 };
                    let count = masks.pack(from, Interval { above, limit }, to);
                    let expected: Vec<usize> = each_bit(wanted).collect();
                    assert_eq!(count, expected.len(), "{numbers:?}");
                    for (to, lane) in expected.into_iter().enumerate() {
                        assert_eq!((packed.0[to], packed.1[to]), (numbers[lane], names[lane]));
                    }
                }
            }
        }
    }

    #[test]
    fn the_widest_registers_give_the_same_bits() {
        let at = |i: u32, k: u32| f64::from(i.wrapping_mul(2_654_435_769) ^ k) / 3.0 - 2e8;
        let [x, y, z] = [1, 2, 3].map(|k| (0..1000).map(|i| at(i, k)).collect::<Vec<f64>>());
        assert_eq!(
            widest(
                #[inline(always)]
                || products(&x, &y, &z)
            ),
            products(&x, &y, &z)
        );
        let [x, y] = [x, y].map(|v| v.into_iter().map(|x| x as f32).collect::<Vec<f32>>());
        assert_eq!(
            widest(
                #[inline(always)]
                || single_products(&x, &y)
            ),
            single_products(&x, &y)
        );
        let fused =
            x.iter().zip(&y).filter(|&(&x, &y)| (x.mul_add(x, y * y) - x * x - y * y).abs() > 0.0).count();
        assert!(fused > 0, "the numbers do not reveal fusion");
    }
}
