//! The points that a rank holds: its owned points, followed by ghosts.
//!
//! A point's position in the table is its *local index*. Owned points come first, and each ghost gets the next free
//! index when it first arrives. Indices never change. Each phase that receives ghosts adds them with `intern`,
//! `receive` or `arrive`, and each phase that measures balls stores radii with `owned_radii2_mut`. The rest of a
//! table does not change after partitioning.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;
use std::sync::OnceLock;

use septet_geometry::coordinate_arrays::CoordinateArrays;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Rank;
use septet_protocol::message::{PointBatch, PointSum, UNKNOWN_RADIUS2};

/// Hashes one 64-bit id by multiplication, for maps whose order is never used.
#[derive(Default)]
pub struct IdHasher(u64);

impl Hasher for IdHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.write_u64(u64::from(b));
        }
    }
    fn write_u64(&mut self, id: u64) {
        self.0 = (self.0 ^ id).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
    }
}

/// Maps ids to local indices.
pub type IdMap = HashMap<u64, u32, BuildHasherDefault<IdHasher>>;

/// The points that a rank holds, as columns. Owned points have the indices below `owned`.
#[derive(Clone, Debug)]
pub struct Table<P> {
    positions: Vec<P>,
    /// Input indices.
    ids: Vec<u64>,
    /// The rank that owns each point.
    owners: Vec<Rank>,
    /// The squared radius of each point's ball, infinite while unknown. Empty if the run needs no radii
    /// ([`Table::with_radii`]).
    radii2: Vec<f64>,
    /// The number of owned points.
    owned: u32,
    /// The local indices of ghosts.
    ghost_indices: IdMap,
    /// The local indices of owned points, created on first use.
    owned_indices: OnceLock<IdMap>,
    /// The coordinates of owned points as arrays, created on first use.
    coordinates: OnceLock<CoordinateArrays<P>>,
}

impl<P> Default for Table<P> {
    fn default() -> Self {
        Table {
            positions: Vec::new(),
            ids: Vec::new(),
            owners: Vec::new(),
            radii2: Vec::new(),
            owned: 0,
            ghost_indices: IdMap::default(),
            owned_indices: OnceLock::new(),
            coordinates: OnceLock::new(),
        }
    }
}

impl<P> Table<P> {
    /// Returns the positions of all points.
    #[inline]
    pub fn positions(&self) -> &[P] {
        &self.positions
    }

    /// Returns the input indices of all points.
    #[inline]
    pub fn ids(&self) -> &[u64] {
        &self.ids
    }

    /// Returns, for each point, the rank that owns it.
    #[inline]
    pub fn owners(&self) -> &[Rank] {
        &self.owners
    }

    /// Returns the squared radius of each point's ball, which is infinite while unknown. The result is empty if the
    /// run needs no radii.
    #[inline]
    pub fn radii2(&self) -> &[f64] {
        &self.radii2
    }

    /// Returns the number of owned points.
    #[inline]
    pub fn owned_len(&self) -> u32 {
        self.owned
    }

    /// Returns the local indices of owned points.
    #[inline]
    pub fn owned(&self) -> Range<u32> {
        0..self.owned
    }

    /// Returns `true` if this rank owns the point with index `at`.
    #[inline]
    pub fn is_owned(&self, at: u32) -> bool {
        at < self.owned
    }

    /// Returns the positions of owned points.
    #[inline]
    pub fn owned_positions(&self) -> &[P] {
        &self.positions[..self.owned as usize]
    }

    /// Returns the input indices of owned points.
    #[inline]
    pub fn owned_ids(&self) -> &[u64] {
        &self.ids[..self.owned as usize]
    }

    /// Returns the squared radii of owned points, for the phases that measure them.
    ///
    /// # Panics
    /// Panics if the table has no radii.
    pub(crate) fn owned_radii2_mut(&mut self) -> &mut [f64] {
        &mut self.radii2[..self.owned as usize]
    }

    /// Consumes the table and returns the input indices of all points.
    pub(crate) fn into_ids(self) -> Vec<u64> {
        self.ids
    }
}

impl<P: Point> Table<P> {
    /// Creates a table of owned points with unknown radii.
    pub fn of_owned(ids: Vec<u64>, positions: Vec<P>, rank: Rank) -> Self {
        let n = ids.len();
        let (owners, radii2) = (vec![rank; n], vec![UNKNOWN_RADIUS2; n]);
        Table { owned: n as u32, positions, ids, owners, radii2, ..Table::default() }
    }

    /// Creates a table of owned points without radii. The spare capacity of `positions`, which is for ghosts, is also
    /// reserved in the column of owners.
    pub fn of_whole(ids: Vec<u64>, positions: Vec<P>, rank: Rank) -> Self {
        let mut owners = Vec::with_capacity(positions.capacity());
        owners.resize(ids.len(), rank);
        Table { owned: ids.len() as u32, positions, ids, owners, ..Table::default() }
    }

    /// Adds an unknown radius for each point that has none.
    pub fn with_radii(&mut self) {
        self.radii2.resize(self.ids.len(), UNKNOWN_RADIUS2);
    }

    /// Returns the number of owned points and the sum of their hashes.
    pub(crate) fn owned_sum(&self) -> PointSum {
        PointSum::of(self.owned_ids().iter().copied().zip(self.owned_positions().iter().copied()))
    }

    /// Returns the local index of a point. Adds the point as a ghost if the table does not contain it.
    pub fn intern(&mut self, id: u64, position: P, owner: Rank, radius2: f64) -> u32 {
        if let Some(at) = self.find_owned(id) {
            return at;
        }
        let (at, _) = self.receive(id, position, owner);
        if let Some(own) = self.radii2.get_mut(at as usize) {
            *own = radius2;
        }
        at
    }

    /// Returns the local index of a point that another rank owns, and whether the point is new in the table.
    pub fn receive(&mut self, id: u64, position: P, owner: Rank) -> (u32, bool) {
        let next = self.ids.len() as u32;
        let at = *self.ghost_indices.entry(id).or_insert(next);
        if at == next {
            if self.radii2.len() == self.ids.len() {
                self.radii2.push(UNKNOWN_RADIUS2);
            }
            self.ids.push(id);
            self.positions.push(position);
            self.owners.push(owner);
        }
        (at, at == next)
    }

    /// Reserves capacity for `more` ghosts in the map of their ids.
    pub fn reserve_ghosts(&mut self, more: usize) {
        self.ghost_indices.reserve(more);
    }

    /// Returns the coordinates of owned points as arrays.
    pub fn coordinates(&self) -> &CoordinateArrays<P> {
        self.coordinates.get_or_init(|| CoordinateArrays::of(self.owned_positions().iter().copied()))
    }

    /// Returns the local index of an owned point.
    pub fn find_owned(&self, id: u64) -> Option<u32> {
        let owned_indices = self
            .owned_indices
            .get_or_init(|| self.owned_ids().iter().zip(0u32..).map(|(&id, i)| (id, i)).collect());
        owned_indices.get(&id).copied()
    }

    /// Corrects the owner of a ghost, if the table contains it.
    pub fn set_owner(&mut self, id: u64, owner: Rank) {
        if let Some(&at) = self.ghost_indices.get(&id) {
            self.owners[at as usize] = owner;
        }
    }

    /// Interns all points of a batch. Returns their local indices.
    pub fn intern_all(&mut self, batch: &PointBatch<P>) -> Vec<u32> {
        (0..batch.len())
            .map(|i| self.intern(batch.ids[i], batch.positions[i], batch.owners[i], batch.radii2[i]))
            .collect()
    }

    /// Adds all points of a batch, none of which this rank owns, with their radii. Returns their local indices.
    pub fn receive_all(&mut self, batch: &PointBatch<P>) -> Vec<u32> {
        (0..batch.len())
            .map(|i| {
                let (at, _) = self.receive(batch.ids[i], batch.positions[i], batch.owners[i]);
                self.radii2[at as usize] = batch.radii2[i];
                at
            })
            .collect()
    }

    /// Returns the local index of a point, owned or ghost.
    pub fn find(&self, id: u64) -> Option<u32> {
        self.ghost_indices.get(&id).copied().or_else(|| self.find_owned(id))
    }

    /// Finds the owned points among a few `ids` in one scan over the table, and returns their local indices.
    pub fn owned_among(&self, ids: &[u64]) -> Vec<u32> {
        self.owned_ids().iter().zip(0u32..).filter(|(id, _)| ids.contains(id)).map(|(_, i)| i).collect()
    }

    /// Appends a point to a batch.
    pub fn export(&self, at: u32, batch: &mut PointBatch<P>) {
        let i = at as usize;
        let radius2 = self.radii2.get(i).copied().unwrap_or(UNKNOWN_RADIUS2);
        batch.push(self.ids[i], self.positions[i], self.owners[i], radius2);
    }

    /// Returns the points with these indices, without owners and radii.
    pub(crate) fn copies(&self, indices: &[u32]) -> PointBatch<P> {
        let each = || indices.iter().map(|&i| i as usize);
        PointBatch::in_transit(
            each().map(|i| self.ids[i]).collect(),
            each().map(|i| self.positions[i]).collect(),
        )
    }

    /// Returns the points with these indices, without radii.
    pub(crate) fn points(&self, indices: &[u32]) -> PointBatch<P> {
        PointBatch {
            owners: Bulk(indices.iter().map(|&i| self.owners[i as usize]).collect()),
            radii2: Bulk(vec![UNKNOWN_RADIUS2; indices.len()]),
            ..self.copies(indices)
        }
    }
}
