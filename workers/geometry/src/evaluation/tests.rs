//! Tests of items and rules.

use glam::DVec3;

use super::*;

/// Halves numbers until they are 1. The results are the odd numbers.
struct Halves(u64);

impl Evaluation for Halves {
    fn count(&self) -> u64 {
        self.0
    }

    fn first(&self, range: Range<u64>) -> Items {
        let mut items = Items::default();
        range.for_each(|n| items.push(|words| words.push(n + 1)));
        items
    }

    fn evaluate(&self, item: &[u64], made: &mut Made) {
        let n = u64::of(item);
        made.lane(|own| own.sequential(n as usize, (), |(), _| ()));
        if n % 2 == 1 {
            made.results.push(|words| words.push(n));
        }
        if n > 1 {
            made.next.push(|words| words.push(n / 2));
        }
    }

    fn stops(&self, progress: &Progress) -> bool {
        progress.levels > 60
    }
}

#[test]
fn values_round_trip_and_short_items_read_as_zero() {
    type Value = (At<DVec3>, Option<(u32, f64)>, Vec<[u64; 2]>);
    let value: Value = (At(DVec3::new(1.0, -0.0, f64::MAX)), Some((7, 0.5)), vec![[1, 2], [3, u64::MAX]]);
    let mut items = Items::default();
    items.push(|words| value.write(words));
    items.push(|_| ());
    let read: Vec<Value> = items.read();
    assert_eq!(read[0], value);
    assert_eq!(read[1], (At(DVec3::ZERO), None, Vec::new()));
    assert_eq!(Items::from_parts(vec![2], vec![1]), None);
}

#[test]
fn levels_are_in_order_and_parts_cost_the_same_together() {
    let rule = Halves(20);
    let meter = Cost::of_subproblem(false);
    let whole = alone(&rule, |items| Made::of(&rule, items.iter(), &meter));
    assert_eq!(whole.levels.len(), 5);
    assert_eq!(whole.levels[1].read::<u64>(), [1, 1, 3, 3, 5, 5, 7, 7, 9, 9]);
    let first = rule.first(0..20);
    let (results, next, cost) = Made::of(&rule, first.iter(), &meter).into_parts(false);
    let mut parts = Made::new(&meter);
    for part in first.parts([3, 0, 17]) {
        parts.append(Made::of(&rule, part.iter(), &meter));
    }
    assert_eq!(parts.into_parts(false), (results, next, cost.clone()));
    // A lane of n steps for each n up to 20, and a scan.
    assert_eq!((cost.work(), cost.depth()), (210 + 20, 20 + 1));
}

#[test]
fn maps_have_one_level() {
    let rule = Map { items: &[2u64, 5, 9], function: |n: u64, _: &mut Cost| n as f64 };
    let meter = Cost::of_subproblem(false);
    let made = alone(&rule, |items| Made::of(&rule, items.iter(), &meter));
    assert_eq!(made.read::<f64>(), [2.0, 5.0, 9.0]);
    assert!(rule.is_flat() && made.levels.len() == 1);
}
