//! Tell and probe: cells on which stars disagree are told to their vertices, and ask for a point.
//!
//! **Statement.** The stars of all points run in steps. In a step:
//! 1. Every star adds the points that it has received to its candidates, and reports its changes ([`crate::splaying::step`]).
//! 2. The registers find the cells that some but not all of their vertices have ([`crate::splaying::register`]). The vertices that
//!    have a refuted cell receive the witnesses.
//! 3. Each other of these cells asks one leaf for the point nearest to its circumcentre ([`crate::splaying::probes`]). All vertices
//!    of the cell receive the point, if it lies in the circumsphere.
//! 4. A cell without an answer is told to the vertices that lack it.
//!
//! The steps end if no register has a message. Then all stars agree ([`crate::splaying`] has the proof).
//!
//! **Source.** Shewchuk's star splaying (see [`crate::splaying::splay`]), in which stars do not know which other stars have a cell.
//!
//! **Rounds.** A *round of repair* is a step in which registers send messages. The certificate and the fallback are those of
//! splaying. Reports, messages of registers, questions and answers each travel in rounds of the machine.
//!
//! **Work and depth.** As for splaying, and the delivery of the reports. Stars, registers and each level of the tree that
//! questions pass are steps of their phases.
//!
//! **Departure.** As for splaying, the messages of a step do not depend on the owners of the stars.

use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;

use crate::config::Repair;
use crate::machine::context::Context;
use crate::splaying::all_stars::step;
use crate::splaying::messages::{Objections, Question};
use crate::splaying::pass::{AllPoints, Passed, Start, most_rounds};
use crate::splaying::pending::{Pending, StepOutput};
use crate::splaying::probes::{Probes, Questions};
use crate::splaying::register::{Notices, Registers};
use crate::splaying::splay::proposal;
use crate::stars::check::Agreement;
use crate::stars::owned::{Stars, StarsView};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// Runs steps until no register sends a message.
pub(crate) async fn tell<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    agreement: &Agreement,
    start: Start,
    all: AllPoints,
) -> Result<Passed, TransportError> {
    cx.enter(Phase::Repair)?;
    let leaves = subdomain.leaves();
    let (gathered, mut steps) = start.into_parts();
    let mut pending = Pending::new(gathered);
    if !(pending.is_empty() && agreement.disagreements().is_empty()) {
        stars.extract_links(table);
    }
    let (mut registers, mut output) = open(table, stars, agreement);
    let last = most_rounds(cx.config(), all.count);
    let mut rounds = 0;
    // All ranks step together, so they agree on the number of the round.
    for round in 1.. {
        steps += 1;
        if !pending.is_empty() {
            let (own, charges) = step(cx, leaves, table, stars, &mut pending, Repair::Probe);
            charges.enter(cx, 2 * steps);
            output.append(own);
        }
        let mut reports = Pending::new(Vec::new());
        output.send(cx, table, &mut reports, round);
        output = StepOutput::default();
        if !cx.exchange_if(!reports.is_empty() || registers.has_fresh()).await? {
            break;
        }
        reports.receive(cx, table, stars);
        reports.sort();
        let mut notices = registers.settle(cx, leaves, &reports, 2 * steps + 1);
        if round > last {
            notices = Notices::default();
        }
        if !notices.messages.is_empty() {
            rounds = round;
        }
        let questions = Questions { cells: notices.questions, round, heaviest: all.heaviest };
        let answered = ask(cx, subdomain, table, &mut pending, questions, steps).await?;
        let mut answered = answered.into_iter().peekable();
        notices.messages.proposals.retain(|told| {
            let told = Question { star: told.from, cell: told.cell };
            while answered.next_if(|other| *other < told).is_some() {}
            answered.peek() != Some(&told)
        });
        notices.messages.send(cx, table, &mut pending, round);
        // If the registers have no messages for other ranks, no rank may have sent a message.
        cx.exchange_if(true).await?;
        pending.receive(cx, table, stars);
    }
    Ok(Passed { rounds, steps })
}

/// Returns the registers of the cells of smallest vertices that the check found open, and the reports of the others.
fn open<P: Point>(
    table: &Table<P>,
    stars: &Stars<P>,
    agreement: &Agreement,
) -> (Registers<P>, StepOutput<P>) {
    let view = StarsView::new(table, stars);
    let found = agreement.disagreements().iter().filter_map(|d| proposal(stars, d));
    let (own, proposals) = found.partition(|found| view.smallest(&found.cell) == found.from);
    (Registers::new(own), StepOutput { proposals, objections: Objections::default() })
}

/// Sends the questions of a step in a round of repair, and waits for the answers. Returns the questions of this rank that got
/// an answer, sorted. All ranks call this in the same steps.
async fn ask<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    pending: &mut Pending<P>,
    questions: Questions<P::Cell>,
    step: u32,
) -> Result<Vec<Question<P::Cell>>, TransportError> {
    cx.switch(Phase::ProbeCells)?;
    let mut probes = Probes::launch(cx, subdomain, table, questions);
    loop {
        probes.receive(cx, table, &mut pending.answers)?;
        pending.receive_answers(cx, table);
        if !cx.exchange().await? {
            break;
        }
    }
    let answered = probes.finish(cx, step);
    cx.enter(Phase::Repair)?;
    Ok(answered)
}
