//! Cells that ask for a point in their circumsphere.
//!
//! **Statement.** The register of an open cell that no star has refuted asks once ([`crate::splaying::register`]). The question goes
//! to one leaf, the nearest to the circumcentre by the boxes on its way ([`crate::neighbours::descent::centres`]). The *answer* is the
//! point of this leaf nearest to the centre, if it lies in the open circumsphere by the exact predicate. It becomes a candidate of all
//! vertices of the cell in the next step.
//!
//! After the first [`OF_ONE_LEAF`] rounds of repair, few cells are open, and one leaf rarely has an answer for them. Then a question goes
//! to every leaf that the ball meets, as the balls of the descent do. On scans, this saves a third of the rounds.
//!
//! With weights, the ball has the centre of the sphere orthogonal to the corners, and contains all points in conflict with the
//! cell, whose weights are at most the largest of all ([`septet_geometry::site`]).
//!
//! The circumcentre is rounded. It only decides which leaf is asked and which point is tested. A point that the predicate accepts
//! is in conflict with the cell, and other points are dropped.
//!
//! **Source.** None: the probe of the punt (`crate::neighbours::descent`), for balls of cells.
//!
//! **Work and depth.** In a leaf, a vector step over the cells computes the centres, and another one tests the answers. The
//! descent is charged between them, level by level.
//!
//! **Rounds.** Replies and answers take at most twice as many rounds as there are shared levels, and one more.

use std::collections::BTreeMap;

use septet_geometry::cost::Sweep;
use septet_geometry::measure::circumcentre;
use septet_geometry::point::{Point, dist2};
use septet_geometry::predicates::{ExactTests, Sign, in_sphere, orientation};
use septet_geometry::range::rounded_into;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::transport::TransportError;

use crate::config::Fault;
use crate::machine::context::Context;
use crate::neighbours::descent::Descent;
use crate::neighbours::descent::centres::{AT_CENTRE, Centre, IN_BALL};
use crate::splaying::messages::{GatheredPoint, Question, corners};
use crate::splaying::wire::send_points;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// The number of steps of the phase for one step of repair: one for each level of the tree, one before and one after them.
const STEPS: u32 = NodeId::DEEPEST + 3;

/// The number of rounds of repair in which a cell asks one leaf. Later, few cells are open.
const OF_ONE_LEAF: u32 = 8;

/// The cells that ask in one step.
pub(super) struct Questions<C> {
    pub(super) cells: Vec<Question<C>>,
    /// The round of repair.
    pub(super) round: u32,
    /// The largest weight of all points; 0 without weights.
    pub(super) heaviest: f64,
}

/// The questions of one step, from the launch to the last answer.
pub(super) struct Probes<'a, P: Point> {
    leaves: &'a [Leaf<P>],
    descent: Descent<'a, P>,
    /// The cells that asked, by the positions of their balls. Sorted.
    asked: Vec<Question<P::Cell>>,
    /// Whether each of them got an answer.
    answered: Vec<bool>,
    /// The exact tests of answers, by leaf.
    exact_tests: BTreeMap<u32, ExactTests>,
}

impl<'a, P: Point> Probes<'a, P> {
    /// Sends the balls of cells down the tree.
    pub(super) fn launch(
        cx: &mut Context<P>,
        subdomain: &'a Subdomain<P>,
        table: &Table<P>,
        Questions { cells: mut asked, round, heaviest }: Questions<P::Cell>,
    ) -> Self {
        let leaves = subdomain.leaves();
        asked.sort_unstable();
        let mut balls = Vec::with_capacity(asked.len());
        asked.retain(|question| {
            let corners = corners(table, &question.cell);
            let at = circumcentre(&corners.as_ref()[..=P::DIM]);
            let mut radius2 = dist2(at, corners.as_ref()[0]);
            if P::IS_WEIGHTED {
                radius2 += heaviest - corners.as_ref()[0].weight();
            }
            let leaf = leaf_number(leaves, question.star);
            // A place in a message has digits in the exact range.
            let at = rounded_into(at).filter(|_| radius2.is_finite());
            balls.extend(at.map(|at| Centre { at, radius2, leaf }));
            at.is_some()
        });
        let search = if round > OF_ONE_LEAF { IN_BALL } else { AT_CENTRE };
        let at = cx.round();
        cx.tally(at).probes += asked.len() as u64;
        let mut probes = Probes {
            leaves,
            descent: Descent::new(subdomain, search, &[]),
            answered: vec![false; asked.len()],
            asked,
            exact_tests: BTreeMap::new(),
        };
        probes.descent.launch_centres(cx, table, &balls);
        probes
    }

    /// Handles the queries and the replies of a round. Adds the answers for owned vertices to `answers` and sends the others to
    /// the owners of their vertices.
    pub(super) fn receive(
        &mut self,
        cx: &mut Context<P>,
        table: &mut Table<P>,
        answers: &mut Vec<GatheredPoint>,
    ) -> Result<(), TransportError> {
        self.descent.receive(cx, table)?;
        self.answer(cx, table, answers);
        Ok(())
    }

    /// Tests the points of all complete lists, and passes on those that lie in the circumspheres of their cells.
    pub(super) fn answer(&mut self, cx: &mut Context<P>, table: &Table<P>, answers: &mut Vec<GatheredPoint>) {
        let complete = self.descent.take_complete();
        if cx.config().fault.is_some_and(Fault::drops_answers) {
            return;
        }
        let mut away = BTreeMap::<_, Vec<GatheredPoint>>::new();
        for nearest in complete.iter().filter(|nearest| !nearest.list.is_empty()) {
            let Question { star: asking, cell, .. } = self.asked[nearest.point as usize];
            let exact = ExactTests::so_far();
            let inside = nearest.list.iter().copied().filter(|&point| is_inside(table, &cell, point));
            let inside: Vec<u32> = inside.collect();
            *self.exact_tests.entry(leaf_number(self.leaves, asking)).or_default() += exact.since();
            self.answered[nearest.point as usize] |= !inside.is_empty();
            let inside = inside.into_iter();
            for (point, &star) in inside.flat_map(|point| cell.as_ref().iter().map(move |star| (point, star)))
            {
                let answer = GatheredPoint { star, point };
                if table.is_owned(star) {
                    answers.push(answer);
                } else {
                    away.entry(table.owners()[star as usize]).or_default().push(answer);
                }
            }
        }
        send_points(cx, table, away);
    }

    /// Charges the questions of step number `step`. Returns the questions of this rank that got an answer, sorted.
    pub(super) fn finish(self, cx: &mut Context<P>, step: u32) -> Vec<Question<P::Cell>> {
        let first = step * STEPS;
        let mut sweeps: BTreeMap<u32, Sweep> = BTreeMap::new();
        for question in &self.asked {
            sweeps.entry(leaf_number(self.leaves, question.star)).or_default().visit();
        }
        for (leaf, sweep) in sweeps {
            let answers = self.exact_tests.get(&leaf).copied().unwrap_or_default();
            for (at, exact) in [(first, ExactTests::default()), (first + STEPS - 1, answers)] {
                let mut cost = cx.own_cost();
                cost.charge_sweep(sweep);
                cost.charge_exact_tests(exact);
                let leaf = self.leaves[leaf as usize].id();
                cx.charge(Account::step(Phase::ProbeCells, at, leaf), cost, sweep.items());
            }
        }
        self.descent.finish_cells(cx, first + 1);
        let all = self.asked.into_iter().zip(self.answered);
        all.filter_map(|(question, answered)| answered.then_some(question)).collect()
    }
}

/// Returns `true` if a point lies in the perturbed circumsphere of a cell. A flat cell contains no points.
fn is_inside<P: Point>(table: &Table<P>, cell: &P::Cell, point: u32) -> bool {
    let mut corners = corners(table, cell);
    let corners = &mut corners.as_mut()[..=P::DIM];
    match orientation(corners) {
        Sign::Zero => return false,
        Sign::Negative => corners.swap(0, 1),
        Sign::Positive => {}
    }
    !cell.as_ref().contains(&point) && in_sphere(corners, table.positions()[point as usize])
}
