use super::*;

#[test]
fn vector_steps_and_scans() {
    let mut cost = Cost::ZERO;
    let squares = cost.map(&[1, 2, 3], |x| x * x);
    assert_eq!((squares, cost.work(), cost.depth()), (vec![1, 4, 9], 3, 1));
    let (offsets, total) = cost.scan(&[2, 0, 5]);
    assert_eq!((offsets, total), (vec![0, 2, 2], 7));
    assert_eq!((cost.work(), cost.depth(), cost.depth_log_scan(1024)), (6, 2, 11));
    cost.sequential(5, 0, |a, _| a + 1);
    assert_eq!((cost.work(), cost.depth()), (11, 7));
}

#[test]
fn doubling_an_inner_loop_changes_the_counts() {
    let run = |trips: usize| {
        let mut cost = Cost::ZERO;
        cost.map_nested(&[1, 2, 3], |_, own| own.sequential(trips, 0, |a, _| a + 1));
        (cost.work(), cost.depth())
    };
    assert_eq!(run(4), (12, 4));
    assert_eq!(run(8), (24, 8));
}

#[test]
fn sorting_is_logarithmic_and_stable() {
    let mut cost = Cost::ZERO;
    let mut items = [(3, 'a'), (1, 'b'), (3, 'c'), (2, 'd'), (1, 'e')];
    cost.sort(&mut items, |a, b| a.0.cmp(&b.0));
    assert_eq!(items, [(1, 'b'), (1, 'e'), (2, 'd'), (3, 'a'), (3, 'c')]);
    assert_eq!((cost.work(), cost.depth(), cost.scans()), (15, 3, 0));
}

#[test]
fn sorting_by_keys_is_sorting_and_is_charged_as_that() {
    for (n, digits) in [(0u64, 64), (1, 64), (31, 64), (97, 2), (1000, 4), (1000, 64)] {
        // With few digits most keys differ in their last ones alone.
        let key = |i: u32| 1 << 62 | u64::from(i).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (64 - digits);
        let order = |&a: &u32, &b: &u32| (key(a), a).cmp(&(key(b), b));
        let mut items: Vec<u32> = (0..n as u32).map(|i| i * 7919 % 503).collect();
        let (mut expected, mut cost, mut all) = (items.clone(), Cost::ZERO, Cost::ZERO);
        all.sort(&mut expected, order);
        cost.sort_keyed(&mut items, &mut Vec::new(), key, order);
        assert_eq!((items, cost), (expected, all));
    }
}

#[test]
fn what_is_put_in_place_is_charged_as_sorted() {
    let items: Vec<(usize, u32)> = (0..50).map(|i| (i * 7 % 11, i as u32)).collect();
    let (mut expected, mut cost, mut all) = (items.clone(), Cost::ZERO, Cost::ZERO);
    all.sort(&mut expected, |a, b| a.0.cmp(&b.0));
    assert_eq!((cost.sorted_by_place(&items, |item| item.0, 11), cost), (expected, all));
}

#[test]
fn distinct_numbers_are_charged_as_distinct() {
    let mut seen = Marks::new(10);
    for numbers in [vec![3, 1, 3, 2, 1, 1, 9, 2, u32::MAX, u32::MAX], vec![3, 3], vec![]] {
        let (mut own, mut cost, mut all) = (numbers.clone(), Cost::ZERO, Cost::ZERO);
        let mut expected = numbers;
        all.distinct_inside(&mut expected, Ord::cmp);
        cost.distinct_numbers(&mut own, &mut seen);
        own.sort_unstable();
        assert_eq!((own, cost), (expected, all));
    }
}

#[test]
fn repetitions_are_deleted_and_paid() {
    let mut cost = Cost::ZERO;
    let mut items = vec![3, 1, 3, 2, 1, 1, 9, 2];
    cost.distinct(&mut items, Ord::cmp);
    assert_eq!((items, cost.work(), cost.depth(), cost.scans()), (vec![1, 2, 3, 9], 6 * 8, 6, 1));
    let mut cost = Cost::ZERO;
    cost.distinct_inside(&mut vec![1, 1, 2, 2], Ord::cmp);
    assert_eq!((cost.depth(), cost.scans(), cost.depth_log_scan(1 << 20)), (5, 0, 6));
}

#[test]
fn unions_name_what_is_in_both() {
    let mut cost = Cost::ZERO;
    let both = cost.unite(&[1, 4, 6], &[0, 4, 7, 9]);
    assert_eq!(both, [(0, false), (1, false), (4, true), (6, false), (7, false), (9, false)]);
    // 7 + 4 + 2 + 1.
    assert_eq!((cost.work(), cost.depth(), cost.scans()), (14, 4, 0));
    assert_eq!(cost.unite::<u32>(&[], &[]), []);
    assert_eq!(cost.unite(&[3], &[]), [(3, false)]);
    assert_eq!((cost.work(), cost.depth()), (15, 5));
}

#[test]
fn repeated_reads_are_refused() {
    let mut cost = Cost::ZERO;
    assert_eq!(cost.gather(&[10, 20, 30], &[2, 0]), Ok(vec![30, 10]));
    assert_eq!(cost.gather(&[10, 20, 30], &[2, 2]), Err(2));
}

#[test]
fn shares_of_a_group_merge_as_one() {
    let items: Vec<usize> = (0..100).collect();
    let mut whole = Cost::ZERO;
    whole.pack(&items, |x| x % 2 == 0);
    let mut merged = Cost::ZERO;
    for part in items.chunks(7) {
        let mut own = Cost::ZERO;
        own.pack(part, |x| x % 2 == 0);
        merged.beside(own);
    }
    assert_eq!(whole, merged);
    assert_eq!(ceil_log2(1000), 10);
}

#[test]
fn columns_are_split_together_and_in_order() {
    for count in [0usize, 1, 2, 7, 1000] {
        for (stay, pattern) in
            [(0u8, 0u64), (0, u64::MAX), (1, 0x9249_2492_4924_9249), (0, 0xF0F0_0001_8000_1234)]
        {
            let flags: Vec<u8> = (0..count).map(|i| (pattern >> (i % 64) & 1) as u8).collect();
            let all: Vec<u64> = (0..count as u64).collect();
            let (mut numbers, mut pairs, mut none) = (all.clone(), Vec::new(), Vec::<f64>::new());
            pairs.extend(all.iter().map(|&i| (i, 3 * i)));
            let mut cost = Cost::ZERO;
            let gone = cost.split_arrays(&flags, stay, (&mut numbers, &mut pairs, &mut none));
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
