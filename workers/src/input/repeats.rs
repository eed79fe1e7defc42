//! Coincident points of all ranks.
//!
//! **Statement.** Points are coincident iff their coordinates are equal. The point of the smallest row stands for all
//! points at its coordinates, and the others are removed. With weights, the first of the heaviest sites stands for them;
//! sites of its weight repeat it, and lighter ones are hidden. Equal coordinates have equal hashes. The leading bits of a hash
//! choose a *bin*, and each bin has a *home*, the rank that finds equal hashes in it.
//!
//! **Rounds.** One if no hashes are equal, otherwise four:
//! 1. Each rank sends the hashes of its points to their homes.
//! 2. The homes ask for the points whose hashes are equal.
//! 3. The ranks send these points.
//! 4. The homes compare them and name the points to remove.
//!
//! **Work and depth.** O(1) vector steps over all points, and a sort of the points with equal hashes. A table of bits
//! finds the hashes of a bin that may be equal; it fits into the caches of a core. The steps are not charged.

use septet_geometry::hash::hash_of_place;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, PointBatch};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;

/// Approximate number of points in a bin.
const BIN: u64 = 1 << 14;
/// The largest number of bits that choose a bin.
const MOST_BITS: u32 = 16;
/// Number of points that one core hashes in turn.
const CHUNK: usize = 1 << 15;
/// Number of bits for each point in the table of a bin.
const BITS: usize = 16;

/// The bins of a run, and their homes.
#[derive(Clone, Copy, Debug)]
struct Bins {
    /// Number of leading bits of a hash that choose its bin.
    bits: u32,
    workers: u32,
}

impl Bins {
    /// Returns the bins for this number of rows.
    fn new(rows: u64, workers: u32) -> Self {
        let bins = (rows / BIN).max(u64::from(workers)).next_power_of_two();
        Bins { bits: bins.ilog2().min(MOST_BITS), workers }
    }

    fn len(self) -> usize {
        1 << self.bits
    }

    fn of(self, hash: u64) -> usize {
        // Two shifts, because a shift by 64 bits overflows.
        (hash >> 32 >> (32 - self.bits)) as usize
    }

    /// Returns the home of a bin.
    fn home(self, bin: usize) -> Rank {
        1 + ((bin as u64 * u64::from(self.workers)) >> self.bits) as Rank
    }
}

/// The hashes that a rank sent to one home, and the positions of their points.
#[derive(Clone, Debug, Default)]
struct Sent {
    hashes: Vec<u64>,
    points: Vec<u32>,
}

/// Points that repeat another row or are hidden.
#[derive(Debug, Default)]
struct Removals {
    /// Positions of the points.
    points: Vec<u32>,
    /// For each, the row that it repeats; its own row if it is hidden under a heavier site.
    first: Vec<u64>,
}

/// The rows of the points that were removed.
#[derive(Debug, Default)]
pub(super) struct Removed {
    /// Rows that repeat a row, each with that row, in the order of the rows.
    repeated: Vec<[u64; 2]>,
    /// Rows that are hidden under a heavier site, ascending.
    hidden: Vec<u64>,
}

impl Removed {
    /// Returns the rows that repeat a row, each with that row, and the hidden rows.
    pub(super) fn into_parts(self) -> (Vec<[u64; 2]>, Vec<u64>) {
        (self.repeated, self.hidden)
    }
}

/// Removes the points that do not stand for their coordinates from the points of this rank. Returns their rows. `rows` is
/// the number of rows of all ranks.
///
/// # Errors
/// See [`Context::exchange`].
pub(super) async fn remove_repeats<P: Point>(
    cx: &mut Context<P>,
    points: &mut PointBatch<P>,
    rows: u64,
) -> Result<Removed, TransportError> {
    let bins = Bins::new(rows, cx.config().workers);
    let sent = send_keys(cx, points, bins);
    let (mut home, mut removals) = (Home::default(), Removals::default());
    while cx.exchange().await? {
        home.receive(cx, bins);
        answer(cx, points, &sent)?;
        home.compare(cx)?;
        removals.receive(cx, &sent)?;
    }
    Ok(removals.apply(points))
}

/// Sends the hashes of the points to their homes.
fn send_keys<P: Point>(cx: &mut Context<P>, points: &PointBatch<P>, bins: Bins) -> Vec<Sent> {
    let chunks: Vec<(u32, &[P])> = (0..).step_by(CHUNK).zip(points.positions.chunks(CHUNK)).collect();
    let chunks = cx.map(&chunks, |&(first, points)| by_bins(points, first, bins));
    let mut sent = vec![Sent::default(); cx.config().ranks() as usize];
    for chunk in &chunks {
        for (bin, range) in chunk.ranges() {
            let to = &mut sent[bins.home(bin) as usize];
            to.hashes.extend_from_slice(&chunk.hashes[range.clone()]);
            to.points.extend_from_slice(&chunk.points[range]);
        }
    }
    let keys = (0..).zip(&mut sent).filter(|(_, sent)| !sent.hashes.is_empty());
    let bodies = keys.map(|(home, sent)| (home, Body::Keys(Bulk(std::mem::take(&mut sent.hashes)))));
    cx.send_each(0, bodies.collect::<Vec<_>>());
    sent
}

/// The points of a chunk by bins.
struct Chunk {
    /// The end of each bin.
    ends: Vec<u32>,
    hashes: Vec<u64>,
    points: Vec<u32>,
}

impl Chunk {
    /// Returns the bins with the ranges of their points.
    fn ranges(&self) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).enumerate().map(|(bin, (start, &end))| (bin, start as usize..end as usize))
    }
}

/// Assigns points to bins. The first point has the position `first`.
fn by_bins<P: Point>(points: &[P], first: u32, bins: Bins) -> Chunk {
    let hashes: Vec<u64> = points.iter().map(|&x| hash_of_place(x)).collect();
    let mut ends = vec![0u32; bins.len() + 1];
    for &hash in &hashes {
        ends[bins.of(hash) + 1] += 1;
    }
    for at in 1..ends.len() {
        ends[at] += ends[at - 1];
    }
    let mut chunk = Chunk { ends, hashes: vec![0; points.len()], points: vec![0; points.len()] };
    for (&hash, point) in hashes.iter().zip(first..) {
        let next = &mut chunk.ends[bins.of(hash)];
        (chunk.hashes[*next as usize], chunk.points[*next as usize]) = (hash, point);
        *next += 1;
    }
    chunk.ends.pop();
    chunk
}

/// A hash that a home received.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    hash: u64,
    /// The rank of the point.
    from: Rank,
    /// The position among the hashes from this rank.
    position: u32,
}

/// The home of the hashes of some bins.
#[derive(Debug, Default)]
struct Home {
    /// The keys whose hashes other keys share, by hash.
    alike: Vec<Key>,
}

impl Home {
    /// Receives the hashes, and asks for the points whose hashes are equal.
    fn receive<P: Point>(&mut self, cx: &mut Context<P>, bins: Bins) {
        let lists = cx.take(|m| match &mut m.body {
            Body::Keys(hashes) => Some((m.from, std::mem::take(&mut hashes.0))),
            _ => None,
        });
        if lists.is_empty() {
            return;
        }
        let mut parts: Vec<Vec<Part<'_>>> = vec![Vec::new(); bins.len()];
        for (from, hashes) in &lists {
            let mut first = 0;
            for hashes in hashes.chunk_by(|a, b| bins.of(*a) == bins.of(*b)) {
                parts[bins.of(hashes[0])].push(Part { from: *from, first, hashes });
                first += hashes.len() as u32;
            }
        }
        parts.retain(|parts| !parts.is_empty());
        self.alike = cx.map(&parts, |parts| equal_hashes(parts)).concat();
        cx.send_each(0, by_rank(&self.alike, |keys| Body::Alike(Bulk(keys))));
    }

    /// Receives the points with equal hashes, and names those that do not stand for their coordinates.
    fn compare<P: Point>(&mut self, cx: &mut Context<P>) -> Result<(), TransportError> {
        let mut arrived = cx.take(|m| match &mut m.body {
            Body::Candidates(points) => Some((m.from, std::mem::take(points), 0)),
            _ => None,
        });
        if arrived.is_empty() {
            return Ok(());
        }
        let mut candidates = Vec::with_capacity(self.alike.len());
        for &key in &self.alike {
            // Each rank sent its points in the order of the hashes.
            let of_rank = arrived.binary_search_by_key(&key.from, |(from, ..)| *from).ok();
            let next = of_rank.map(|i| &mut arrived[i]).and_then(|(_, points, next)| {
                *next += 1;
                Some((*points.ids.get(*next - 1)?, *points.positions.get(*next - 1)?))
            });
            let Some((id, at)) = next else { return Err(refused(cx, "a rank sent too few points")) };
            candidates.push(Candidate { key, id, at });
        }
        let mut repeated: Vec<(Key, u64)> = Vec::new();
        for alike in candidates.chunk_by_mut(|a, b| a.key.hash == b.key.hash) {
            // Adding zero removes the sign of a zero.
            let heavier = |a: &P, b: &P| (b.weight() + 0.0).total_cmp(&(a.weight() + 0.0));
            alike.sort_unstable_by(|a, b| {
                lex_cmp(&a.at, &b.at).then(heavier(&a.at, &b.at)).then(a.id.cmp(&b.id))
            });
            for equal in alike.chunk_by(|a, b| lex_cmp(&a.at, &b.at).is_eq()) {
                let first = &equal[0];
                let stands_for = |other: &Candidate<P>| {
                    if heavier(&first.at, &other.at).is_eq() { first.id } else { other.id }
                };
                repeated.extend(equal[1..].iter().map(|other| (other.key, stands_for(other))));
            }
        }
        repeated.sort_unstable_by_key(|(key, _)| (key.from, key.position));
        let bodies = repeated.chunk_by(|a, b| a.0.from == b.0.from).map(|of_rank| {
            let (keys, first) = of_rank.iter().map(|(key, first)| (key.position, *first)).unzip();
            (of_rank[0].0.from, Body::Repeated { keys: Bulk(keys), first: Bulk(first) })
        });
        cx.send_each(0, bodies);
        Ok(())
    }
}

/// A point whose hash another point shares.
struct Candidate<P> {
    key: Key,
    id: u64,
    at: P,
}

/// Hashes of one bin from one rank. The first of them has the position `first` among the hashes from this rank.
#[derive(Clone, Debug)]
struct Part<'a> {
    from: Rank,
    first: u32,
    hashes: &'a [u64],
}

/// A set of hashes as a table of bits. Different hashes may share a bit.
struct Bits(Vec<u64>);

impl Bits {
    /// Adds a hash. Returns `true` if its bit was already set.
    #[inline]
    fn add(&mut self, hash: u64) -> bool {
        let place = hash as usize & (64 * self.0.len() - 1);
        let (word, bit) = (&mut self.0[place / 64], 1 << (place % 64));
        let was = *word & bit != 0;
        *word |= bit;
        was
    }

    #[inline]
    fn has(&self, hash: u64) -> bool {
        let place = hash as usize & (64 * self.0.len() - 1);
        self.0[place / 64] >> (place % 64) & 1 == 1
    }
}

/// Returns the keys of a bin whose hashes other keys share, by hash.
fn equal_hashes(parts: &[Part<'_>]) -> Vec<Key> {
    let words = (parts.iter().map(|part| part.hashes.len()).sum::<usize>() * BITS / 64).next_power_of_two();
    let (mut met, mut again) = (Bits(vec![0; words]), Bits(vec![0; words]));
    for &hash in parts.iter().flat_map(|part| part.hashes) {
        if met.add(hash) {
            again.add(hash);
        }
    }
    let mut keys = Vec::new();
    for Part { from, first, hashes } in parts {
        let all = (*first..).zip(*hashes).filter(|(_, hash)| again.has(**hash));
        keys.extend(all.map(|(position, &hash)| Key { hash, from: *from, position }));
    }
    keys.sort_unstable();
    let equal = keys.chunk_by(|a, b| a.hash == b.hash).filter(|equal| equal.len() > 1);
    equal.flatten().copied().collect()
}

/// Returns a body for each rank with the positions of its keys, in the order of the keys.
fn by_rank<P>(keys: &[Key], body: impl Fn(Vec<u32>) -> Body<P>) -> Vec<(Rank, Body<P>)> {
    let mut of_ranks: std::collections::BTreeMap<Rank, Vec<u32>> = std::collections::BTreeMap::new();
    for key in keys {
        of_ranks.entry(key.from).or_default().push(key.position);
    }
    of_ranks.into_iter().map(|(rank, positions)| (rank, body(positions))).collect()
}

/// Sends the points that homes ask for.
fn answer<P: Point>(
    cx: &mut Context<P>,
    points: &PointBatch<P>,
    sent: &[Sent],
) -> Result<(), TransportError> {
    let asked = cx.take(|m| match &mut m.body {
        Body::Alike(keys) => Some((m.from, std::mem::take(&mut keys.0))),
        _ => None,
    });
    for (home, keys) in asked {
        let mut candidates = PointBatch::default();
        for key in keys {
            let point = point_of(cx, sent, home, key)? as usize;
            candidates.ids.push(points.ids[point]);
            candidates.positions.push(points.positions[point]);
        }
        cx.send_to((NodeId::ROOT, home), Body::Candidates(candidates));
    }
    Ok(())
}

/// Returns the point whose hash has this position among the hashes for a home.
fn point_of<P: Point>(cx: &Context<P>, sent: &[Sent], home: Rank, key: u32) -> Result<u32, TransportError> {
    let point = sent.get(home as usize).and_then(|sent| sent.points.get(key as usize));
    point.copied().ok_or_else(|| refused(cx, "a rank asked for a hash that it did not receive"))
}

fn refused<P: Point>(cx: &Context<P>, reason: &str) -> TransportError {
    TransportError::WorkerFailed { rank: cx.rank(), reason: reason.to_string() }
}

impl Removals {
    /// Notes the points that homes name.
    fn receive<P: Point>(&mut self, cx: &mut Context<P>, sent: &[Sent]) -> Result<(), TransportError> {
        let named = cx.take(|m| match &mut m.body {
            Body::Repeated { keys, first } => {
                Some((m.from, std::mem::take(&mut keys.0), std::mem::take(&mut first.0)))
            }
            _ => None,
        });
        for (home, keys, first) in named {
            for (key, first) in keys.into_iter().zip(first) {
                self.points.push(point_of(cx, sent, home, key)?);
                self.first.push(first);
            }
        }
        Ok(())
    }

    /// Removes the points. Returns their rows.
    fn apply<P: Point>(self, points: &mut PointBatch<P>) -> Removed {
        if self.points.is_empty() {
            return Removed::default();
        }
        let mut keeps = vec![true; points.len()];
        self.points.iter().for_each(|&point| keeps[point as usize] = false);
        let rows = self.points.iter().map(|&point| points.ids[point as usize]);
        let mut pairs: Vec<[u64; 2]> = rows.zip(self.first).map(|(row, first)| [row, first]).collect();
        pairs.sort_unstable();
        points.keep(&keeps);
        let (hidden, repeated): (Vec<_>, Vec<_>) = pairs.into_iter().partition(|[row, first]| row == first);
        Removed { repeated, hidden: hidden.into_iter().map(|[row, _]| row).collect() }
    }
}
