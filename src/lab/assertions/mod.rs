//! Assertions for tests on the counts of runs: depth, levels, rounds, merged results, traffic and growth.
//!
//! A check is a function of counts (an `Outcome`, a `Line` of a sweep, or several of them) and of a bound. If
//! the counts exceed the bound, it returns [`Broken`] with a table of all runs and the first round that exceeds the
//! bound. If there are enough sizes, the error contains the fit of the count. [`assert_counts!`](crate::assert_counts)
//! panics with the error at the line of the test.
//!
//! ```
//! use septet::spec::Workers;
//! use septet::generate::{Kind, Request, generate};
//! use septet::{Points, Spec, assert_counts, simulate};
//!
//! let request = Request { kind: Kind::WellSpaced, n: 1000, dimension: 2, seed: 1, lipschitz: None, ratio: None };
//! let set = generate(&request, &mut |_, _, _| {})?;
//! let Points::Plane(points) = &set.points else { unreachable!() };
//! let mut spec = Spec::default();
//! spec.machine.workers = Workers::Leaves;
//! spec.tree.leaf = Some(100);
//! spec.recursion.spacing = Some(0.0);
//! let run = simulate(points, &spec)?;
//! assert_counts!(run, levels(1.5, -5.0), rounds("merge", 1.5, -5.0), merges(1.5, -5.0), no_repair());
//! assert_counts!([&run, &run], same_counts());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The message of a failed check:
//!
//! ```should_panic
//! # use septet::spec::Workers;
//! # use septet::generate::{Kind, Request, generate};
//! # use septet::{Points, Spec, assert_counts, simulate};
//! # let request = Request { kind: Kind::WellSpaced, n: 1000, dimension: 2, seed: 1, lipschitz: None, ratio: None };
//! # let set = generate(&request, &mut |_, _, _| {}).unwrap();
//! # let Points::Plane(points) = &set.points else { unreachable!() };
//! # let mut spec = Spec::default();
//! # spec.machine.workers = Workers::Leaves;
//! # spec.tree.leaf = Some(100);
//! # spec.recursion.spacing = Some(0.0);
//! # let run = simulate(points, &spec).unwrap();
//! // rounds("merge", 0.0, 2.0): rounds of merge: 5 above 2 = 0 log2 n + 2
//! //             n  workers   seed      counted        bound
//! //           994       13      0            5            2  <- above the bound
//! //   first round above the bound: round 50 of merge, 2 messages, 240 bytes, 1 merged, 0 points
//! assert_counts!(run, rounds("merge", 0.0, 2.0));
//! ```
//!
//! Checks of growth need lines with sizes and seeds. Create the lines with [`crate::experiment::Runner`], read them
//! with [`crate::experiment::read_lines`], or set `Line::seed`.

mod broken;
mod counts;
mod growth;
mod single;

pub use broken::{Broken, Row};
pub use counts::HasCounts;
pub use growth::{exponent, grows_like, level_depth_flat, surface_bytes};
pub use single::{
    bytes, depth_of_levels, levels, levels_over_leaf, merges, messages_per_worker, no_repair, rounds,
    same_counts,
};

/// Panics unless all checks hold: `assert_counts!(run, levels(1.5, -10.0), no_repair())`. The checks are the functions
/// of [`septet::assertions`](crate::assertions) without their first argument.
#[macro_export]
macro_rules! assert_counts {
    ($counted:expr, $($check:ident ( $($argument:expr),* $(,)? )),+ $(,)?) => {{
        let counted = $crate::assertions::HasCounts::lines(&$counted);
        $(
            if let Err(broken) = $crate::assertions::$check(&counted, $($argument),*) {
                let check = concat!(stringify!($check), "(", stringify!($($argument),*), ")");
                panic!("{check}: {broken}");
            }
        )+
    }};
}
