use proptest::prelude::*;

use super::*;
use crate::selection::NeighbourList;

/// The charges of the machine, step by step: every primitive as its sequence of vector steps and scans.
#[derive(Default)]
struct Steps {
    work: u64,
    depth: u64,
    scans: u64,
}

impl Steps {
    fn step(&mut self, items: u64) {
        self.work += items;
        self.depth += 1;
    }

    fn scan(&mut self, items: u64) {
        self.step(items);
        self.scans += 1;
    }

    fn sort(&mut self, items: u64) {
        for _ in 0..ceil_log2(items).max(1) {
            self.step(items);
        }
    }

    fn merge(&mut self, items: u64) {
        let mut left = items;
        while left > 0 {
            self.step(left);
            left = if left == 1 { 0 } else { left.div_ceil(2) };
        }
    }

    fn sequential(&mut self, iterations: u64) {
        for _ in 0..iterations {
            self.step(1);
        }
    }

    /// The price of a primitive.
    fn of(primitive: Primitive, items: u64) -> Price {
        let [step, scan, sort] = [Steps::step, Steps::scan, Steps::sort];
        let sequence: &[fn(&mut Steps, u64)] = match primitive {
            Primitive::VectorStep => &[step],
            Primitive::Scan => &[scan],
            Primitive::Pack => &[step, scan, step],
            Primitive::Split => &[step, scan, scan, step],
            Primitive::BroadcastMap => &[scan, step],
            Primitive::Pairs => &[scan, step, scan],
            Primitive::Sweep | Primitive::Delivery | Primitive::Replicate | Primitive::Combine
                if items == 0 =>
            {
                &[]
            }
            Primitive::Sweep => &[step, scan],
            Primitive::Sort => &[sort],
            Primitive::Distinct => &[sort, step, scan, step],
            Primitive::Delivery => &[sort, scan, step, scan, step],
            Primitive::Replicate => &[scan, step, step, scan, step, scan],
            Primitive::Combine => &[step, step, step, scan],
            Primitive::Merge => &[Steps::merge],
            Primitive::Sequential => &[Steps::sequential],
        };
        let mut steps = Steps::default();
        for part in sequence {
            part(&mut steps, items);
        }
        Price::from_parts([steps.work, steps.depth, steps.scans, 0, 0])
    }
}

/// The price of one call of a method on the meter of a subproblem.
fn cost_of(call: impl FnOnce(&mut Cost)) -> Price {
    let mut cost = Cost::default();
    call(&mut cost);
    cost.price()
}

/// The price of one call of a method on a nested meter.
fn nested_cost_of(call: impl FnOnce(&mut Cost)) -> Price {
    let mut cost = Cost::default().nested();
    call(&mut cost);
    cost.price()
}

/// The price of consecutive calls of primitives.
fn paid(calls: &[(Primitive, usize)]) -> Price {
    let mut all = Price::ZERO;
    for &(primitive, items) in calls {
        all.then(Steps::of(primitive, items as u64));
    }
    all
}

/// The price of consecutive calls of primitives whose scans all run over `items` items.
fn paid_nested(calls: &[(Primitive, usize)], items: usize) -> Price {
    let [work, depth, scans, _, exact] = paid(calls).to_parts();
    let log = ceil_log2(items as u64).max(1) - 1;
    Price::from_parts([work, depth, 0, scans * log, exact])
}

fn swept(items: usize) -> Sweep {
    let mut sweep = Sweep::default();
    sweep.visit_lanes(items);
    sweep
}

struct Ignore;

impl PairVisitor for Ignore {
    fn begin(&mut self, _: usize) -> f64 {
        0.0
    }
    fn visit(&mut self, _: usize, _: f64) -> f64 {
        0.0
    }
    fn end(&mut self, _: usize) {}
}

proptest! {
    /// The price list equals the sum over the steps of each primitive.
    #[test]
    fn prices_are_sums_of_steps(items in prop_oneof![0u64..70, 0u64..100_000]) {
        for primitive in Primitive::ALL {
            prop_assert_eq!(primitive.price(items), Steps::of(primitive, items), "{:?}", primitive);
        }
    }

    /// Every method charges the primitives of its documentation.
    #[test]
    fn methods_charge_their_primitives(mut list in prop::collection::vec(0u32..40, 0..130), other in 0u32..60) {
        use Primitive as P;
        let m = list.len();
        let as_calls = |p: Primitive| paid(&[(p, m)]);
        let flags: Vec<u8> = list.iter().map(|x| (x % 2) as u8).collect();
        let counts: Vec<usize> = list.iter().map(|&x| x as usize).collect();
        prop_assert_eq!(cost_of(|c| drop(c.map(&list, |x| x + 1))), as_calls(P::VectorStep));
        prop_assert_eq!(cost_of(|c| c.update(&mut list.clone(), |x| *x += 1)), as_calls(P::VectorStep));
        prop_assert_eq!(cost_of(|c| _ = c.reduce(&list, 0, |a, x| a + x)), as_calls(P::Scan));
        prop_assert_eq!(cost_of(|c| drop(c.scan(&counts))), as_calls(P::Scan));
        prop_assert_eq!(cost_of(|c| c.broadcast(&mut list.clone(), |x| *x = 0)), as_calls(P::Scan));
        prop_assert_eq!(cost_of(|c| drop(c.map_with(3, &list, |v, x| v + x))), as_calls(P::BroadcastMap));
        prop_assert_eq!(cost_of(|c| drop(c.pack(&list, |x| x % 2 == 0))), as_calls(P::Pack));
        prop_assert_eq!(cost_of(|c| drop(c.split(&list, |x| x % 2 == 0))), as_calls(P::Split));
        let arrays = cost_of(|c| {
            c.split_arrays(&flags, 0, &mut list.clone(), &mut Vec::<u8>::new(), &mut Vec::<u8>::new());
        });
        prop_assert_eq!(arrays, as_calls(P::Split));
        prop_assert_eq!(cost_of(|c| c.sort(&mut list.clone(), Ord::cmp)), as_calls(P::Sort));
        prop_assert_eq!(cost_of(|c| c.distinct(&mut list.clone(), Ord::cmp)), as_calls(P::Distinct));
        let nested = paid_nested(&[(P::Distinct, m)], m);
        prop_assert_eq!(nested_cost_of(|c| c.distinct(&mut list.clone(), Ord::cmp)), nested);
        let mut relabelled = nested;
        relabelled.then(as_calls(P::VectorStep));
        let mut positions = Positions::default();
        positions.make_room(40);
        prop_assert_eq!(nested_cost_of(|c| drop(c.relabel(&mut list.clone(), &mut positions))), relabelled);
        prop_assert_eq!(cost_of(|c| c.charge_sweep(swept(m))), as_calls(P::Sweep));
        prop_assert_eq!(nested_cost_of(|c| c.charge_sweep(swept(m))), paid_nested(&[(P::Sweep, m)], m));
        prop_assert_eq!(cost_of(|c| c.charge_replication(swept(m))), as_calls(P::Replicate));
        prop_assert_eq!(cost_of(|c| c.charge_combination(swept(m))), as_calls(P::Combine));
        prop_assert_eq!(cost_of(|c| c.charge_pairs(swept(m))), as_calls(P::Pairs));
        prop_assert_eq!(cost_of(|c| c.charge_sort(swept(m))), as_calls(P::Sort));
        let merges = [(P::VectorStep, 2 * 12 * m); 5];
        prop_assert_eq!(cost_of(|c| c.charge_list_merges(swept(m), 12)), paid(&merges));
        prop_assert_eq!(cost_of(|c| c.charge_list_merges(swept(m), 1)), Price::ZERO);
        prop_assert_eq!(cost_of(|c| c.charge_lists(swept(m), 1)), Price::ZERO);
        prop_assert_eq!(cost_of(|c| c.charge_lists(swept(m), 2)), paid(&[(P::Sort, m), (P::VectorStep, m)]));
        prop_assert_eq!(cost_of(|c| c.charge_sequence(swept(m))), as_calls(P::Sequential));
        prop_assert_eq!(cost_of(|c| c.charge_delivery(swept(m))), as_calls(P::Delivery));
        prop_assert_eq!(cost_of(|c| c.sequential(m, (), |(), _| ())), as_calls(P::Sequential));
        list.sort_unstable();
        list.dedup();
        let both: Vec<u32> = (0..other).collect();
        let merged = paid(&[(P::Merge, list.len() + both.len())]);
        prop_assert_eq!(cost_of(|c| drop(c.unite(&list, &both))), merged);
        let points: Vec<glam::DVec2> = list.iter().map(|&x| glam::DVec2::splat(f64::from(x))).collect();
        let pairs = paid(&[(P::Pairs, points.len() * points.len())]);
        let columns = CoordinateArrays::of(points.iter().copied());
        prop_assert_eq!(cost_of(|c| c.all_pairs(&points, &columns, &mut Ignore)), pairs);
        let all = points.len() * points.len();
        let lists = paid(&[(P::Pairs, all), (P::VectorStep, all)]);
        prop_assert_eq!(cost_of(|c| c.all_pairs_to_lists(&points, &columns, &mut Ignore)), lists);
        let nearest = paid(&[(P::Pairs, all), (P::Sort, all), (P::VectorStep, all)]);
        prop_assert_eq!(cost_of(|c| c.all_pairs_to_nearest(&points, &columns, 3, &mut Ignore)), nearest);
        prop_assert_eq!(cost_of(|c| c.all_pairs_to_nearest(&points, &columns, 1, &mut Ignore)), pairs);
        prop_assert_eq!(cost_of(|c| c.all_pairs_in_blocks(&KdBlocks::of(&points), &mut Ignore)), pairs);
    }
}

#[test]
fn sweeps_count_all_items_that_the_machine_tests() {
    let points: Vec<glam::DVec2> = (0..100).map(|i| glam::DVec2::splat(f64::from(i))).collect();
    let mut sweep = Sweep::default();
    sweep.each_in_blocks(&KdBlocks::of(&points), points[0], 2.0, 0, &mut NeighbourList::default());
    sweep.each_distance(&CoordinateArrays::of(points.iter().copied()), 10..30, points[0], 2.0, |_, _| 2.0);
    assert_eq!(sweep.items(), 120);
}

#[test]
fn vector_steps_and_scans() {
    let mut cost = Cost::default();
    let squares = cost.map(&[1, 2, 3], |x| x * x);
    assert_eq!((squares, cost.work(), cost.depth()), (vec![1, 4, 9], 3, 1));
    let (offsets, total) = cost.scan(&[2, 0, 5]);
    assert_eq!((offsets, total), (vec![0, 2, 2], 7));
    assert_eq!((cost.work(), cost.depth(), cost.price().depth_log_scan(1024)), (6, 2, 11));
    cost.sequential(5, 0, |a, _| a + 1);
    assert_eq!((cost.work(), cost.depth()), (11, 7));
}

#[test]
fn doubling_an_inner_loop_changes_the_counts() {
    let run = |trips: usize| {
        let mut cost = Cost::default();
        cost.map_nested(&[1, 2, 3], |_, own| own.sequential(trips, 0, |a, _| a + 1));
        (cost.work(), cost.depth())
    };
    assert_eq!(run(4), (12, 4));
    assert_eq!(run(8), (24, 8));
}

#[test]
fn sorting_is_logarithmic_and_stable() {
    let mut cost = Cost::default();
    let mut items = [(3, 'a'), (1, 'b'), (3, 'c'), (2, 'd'), (1, 'e')];
    cost.sort(&mut items, |a, b| a.0.cmp(&b.0));
    assert_eq!(items, [(1, 'b'), (1, 'e'), (2, 'd'), (3, 'a'), (3, 'c')]);
    assert_eq!((cost.work(), cost.depth(), cost.price().scans()), (15, 3, 0));
}

#[test]
fn sorting_by_keys_is_charged_as_a_sort() {
    for (n, digits) in [(0u64, 64), (1, 64), (31, 64), (97, 2), (1000, 4), (1000, 64)] {
        // If `digits` is small, most keys differ only in their last bits.
        let key = |i: u32| 1 << 62 | u64::from(i).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (64 - digits);
        let order = |&a: &u32, &b: &u32| (key(a), a).cmp(&(key(b), b));
        let mut items: Vec<u32> = (0..n as u32).map(|i| i * 7919 % 503).collect();
        let (mut expected, mut cost, mut all) = (items.clone(), Cost::default(), Cost::default());
        all.sort(&mut expected, order);
        cost.sort_keyed(&mut items, &mut Vec::new(), key, order);
        assert_eq!((items, cost), (expected, all));
    }
}

#[test]
fn counting_sorts_are_charged_as_sorts() {
    let items: Vec<(usize, u32)> = (0..50).map(|i| (i * 7 % 11, i as u32)).collect();
    let (mut expected, mut cost, mut all) = (items.clone(), Cost::default(), Cost::default());
    all.sort(&mut expected, |a, b| a.0.cmp(&b.0));
    assert_eq!((cost.sort_by_position(&items, |item| item.0, 11), cost), (expected, all));
}

#[test]
fn distinct_indices_are_charged_as_distinct() {
    let mut seen = Marks::new(10);
    for numbers in [vec![3, 1, 3, 2, 1, 1, 9, 2, u32::MAX, u32::MAX], vec![3, 3], vec![]] {
        let (mut own, mut cost, mut all) = (numbers.clone(), Cost::default(), Cost::default());
        let mut expected = numbers;
        all.distinct(&mut expected, Ord::cmp);
        cost.distinct_indices(&mut own, &mut seen);
        own.sort_unstable();
        assert_eq!((own, cost), (expected, all));
    }
}

#[test]
fn repetitions_are_removed_and_charged() {
    let mut cost = Cost::default();
    let mut items = vec![3, 1, 3, 2, 1, 1, 9, 2];
    cost.distinct(&mut items, Ord::cmp);
    assert_eq!((items, cost.work(), cost.depth(), cost.price().scans()), (vec![1, 2, 3, 9], 6 * 8, 6, 1));
    let mut nested = Cost::default().nested();
    nested.distinct(&mut vec![1, 1, 2, 2], Ord::cmp);
    assert_eq!((nested.depth(), nested.price().scans(), nested.price().depth_log_scan(1 << 20)), (5, 0, 6));
}

#[test]
fn unions_mark_common_items() {
    let mut cost = Cost::default();
    let both = cost.unite(&[1, 4, 6], &[0, 4, 7, 9]);
    assert_eq!(both, [(0, false), (1, false), (4, true), (6, false), (7, false), (9, false)]);
    // 7 + 4 + 2 + 1.
    assert_eq!((cost.work(), cost.depth(), cost.price().scans()), (14, 4, 0));
    assert_eq!(cost.unite::<u32>(&[], &[]), []);
    assert_eq!(cost.unite(&[3], &[]), [(3, false)]);
    assert_eq!((cost.work(), cost.depth()), (15, 5));
}

/// A record determines the price: the calls in sequence, the calls of all lanes, and the longest lane.
#[test]
fn records_determine_prices() {
    fn depth_of(tape: &Tape) -> u64 {
        let depth = |step: &Step| match step {
            Step::Call(call) => Steps::of(call.primitive, call.items).depth(),
            Step::Lanes(lanes) => depth_of(&lanes.longest),
        };
        tape.steps().iter().map(depth).sum()
    }
    let work = |(call, times): (&Call, &u64)| Steps::of(call.primitive, call.items).work() * times;
    let mut cost = Cost::of_subproblem(true);
    let squares = cost.map(&[3usize, 0, 5], |x| x * x);
    cost.map_nested(&squares, |&square, own| {
        if square > 0 {
            own.sort(&mut vec![0; square], Ord::cmp);
            own.map_nested(&[1, 2], |_, inner| inner.sequential(square, (), |(), _| ()));
        }
    });
    let price = cost.price();
    let tape = cost.into_tape().unwrap_or_default();
    let Some(Step::Lanes(lanes)) = tape.steps().last() else { panic!("no lanes in {tape:?}") };
    assert_eq!((lanes.lanes, tape.steps().len()), (3, 2));
    assert_eq!(depth_of(&tape), price.depth());
    assert_eq!(3 + lanes.calls.iter().map(work).sum::<u64>(), price.work());
    assert_eq!(Cost::default().into_tape(), None);
}

#[test]
fn shares_of_a_group_merge_as_one() {
    let items: Vec<usize> = (0..100).collect();
    let mut whole = Cost::default();
    whole.pack(&items, |x| x % 2 == 0);
    let mut merged = Price::ZERO;
    for part in items.chunks(7) {
        let mut own = Cost::default();
        own.pack(part, |x| x % 2 == 0);
        merged.join(own.price());
    }
    assert_eq!(whole.price(), merged);
    assert_eq!(ceil_log2(1000), 10);
}

#[test]
fn arrays_are_split_together_and_in_order() {
    for count in [0usize, 1, 2, 7, 1000] {
        for (stay, pattern) in
            [(0u8, 0u64), (0, u64::MAX), (1, 0x9249_2492_4924_9249), (0, 0xF0F0_0001_8000_1234)]
        {
            let flags: Vec<u8> = (0..count).map(|i| (pattern >> (i % 64) & 1) as u8).collect();
            let all: Vec<u64> = (0..count as u64).collect();
            let (mut numbers, mut pairs, mut none) = (all.clone(), Vec::new(), Vec::<f64>::new());
            pairs.extend(all.iter().map(|&i| (i, 3 * i)));
            let mut cost = Cost::default();
            let gone = cost.split_arrays(&flags, stay, &mut numbers, &mut pairs, &mut none);
            let (there, away): (Vec<u64>, Vec<u64>) = all.iter().partition(|&&i| flags[i as usize] == stay);
            assert_eq!((&numbers, &gone.0), (&there, &away));
            assert!(
                pairs.iter().zip(&there).all(|(pair, &i)| *pair == (i, 3 * i)) && pairs.len() == there.len()
            );
            assert!(
                gone.1.iter().zip(&away).all(|(pair, &i)| *pair == (i, 3 * i)) && gone.1.len() == away.len()
            );
            assert!(none.is_empty() && gone.2.is_empty());
        }
    }
}
