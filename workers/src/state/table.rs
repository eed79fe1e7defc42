//! The points a worker holds: its home points first, then foreign ones it was sent.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::OnceLock;

use septet_geometry::coordinate_arrays::CoordinateArrays;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Rank;
use septet_protocol::message::PointBatch;

/// Hashes one 64-bit id by multiplication. Never iterated over.
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

/// From an id to a position.
pub type IdMap = HashMap<u64, u32, BuildHasherDefault<IdHasher>>;

/// Points by local number: structure of arrays. Numbers below `owned` are at home here.
#[derive(Clone, Debug)]
pub struct Table<P> {
    /// Coordinates.
    pub positions: Vec<P>,
    /// Input indices.
    pub ids: Vec<u64>,
    /// The rank where each is at home.
    pub owners: Vec<Rank>,
    /// Squared radius of each ball; infinite while unknown. Empty while nobody needs it ([`Table::with_radii`]).
    pub radii2: Vec<f64>,
    /// Number of home points.
    pub owned: u32,
    /// Foreign points.
    ghosts: IdMap,
    /// Home points: made when first asked for.
    owned_points: OnceLock<IdMap>,
    /// Their positions in coordinates: made when first asked for.
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
            ghosts: IdMap::default(),
            owned_points: OnceLock::new(),
            coordinates: OnceLock::new(),
        }
    }
}

impl<P: Point> Table<P> {
    /// A table of home points.
    pub fn of_owned(ids: Vec<u64>, positions: Vec<P>, rank: Rank) -> Self {
        let n = ids.len();
        let (owners, radii2) = (vec![rank; n], vec![f64::INFINITY; n]);
        let (ghosts, owned_points, coordinates) = (IdMap::default(), OnceLock::new(), OnceLock::new());
        Table { positions, ids, owners, radii2, owned: n as u32, ghosts, owned_points, coordinates }
    }

    /// A table of home points without radii, with as much room for others as their positions leave.
    pub fn of_whole(ids: Vec<u64>, positions: Vec<P>, rank: Rank) -> Self {
        let mut owners = Vec::with_capacity(positions.capacity());
        owners.resize(ids.len(), rank);
        Table { owned: ids.len() as u32, positions, ids, owners, ..Table::default() }
    }

    /// Makes room for the radii of all points.
    pub fn with_radii(&mut self) {
        self.radii2.resize(self.ids.len(), f64::INFINITY);
    }

    /// The local number of a point, which is added as a foreign one if it is not here yet.
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

    /// The same for a point that is known not to be at home here. Was it new?
    pub fn receive(&mut self, id: u64, position: P, owner: Rank) -> (u32, bool) {
        let next = self.ids.len() as u32;
        let at = *self.ghosts.entry(id).or_insert(next);
        if at == next {
            if self.radii2.len() == self.ids.len() {
                self.radii2.push(f64::INFINITY);
            }
            self.ids.push(id);
            self.positions.push(position);
            self.owners.push(owner);
        }
        (at, at == next)
    }

    /// Takes in a point that was sent, unless it is at home here; new ones are noted.
    pub(crate) fn arrive(&mut self, points: &PointBatch<P>, at: usize, own: Rank, arrived: &mut Vec<u32>) {
        let (id, owner) = (points.ids[at], points.owners[at]);
        if owner == own {
            return;
        }
        let (number, is_new) = self.receive(id, points.positions[at], owner);
        if is_new {
            arrived.push(number);
        }
    }

    /// Makes room among the numbers of foreign points for so many more.
    pub fn reserve_ghosts(&mut self, more: usize) {
        self.ghosts.reserve(more);
    }

    /// The home points in coordinates.
    pub fn coordinates(&self) -> &CoordinateArrays<P> {
        self.coordinates
            .get_or_init(|| CoordinateArrays::of(self.positions[..self.owned as usize].iter().copied()))
    }

    /// The local number of a home point.
    pub fn find_owned(&self, id: u64) -> Option<u32> {
        let owned_points = self.owned_points.get_or_init(|| {
            let own = &self.ids[..self.owned as usize];
            own.iter().zip(0u32..).map(|(&id, i)| (id, i)).collect()
        });
        owned_points.get(&id).copied()
    }

    /// Corrects where a foreign point is at home.
    pub fn set_owner(&mut self, id: u64, owner: Rank) {
        if let Some(&at) = self.ghosts.get(&id) {
            self.owners[at as usize] = owner;
        }
    }

    /// Interns all points of a batch, in order.
    pub fn intern_all(&mut self, batch: &PointBatch<P>) -> Vec<u32> {
        (0..batch.len())
            .map(|i| self.intern(batch.ids[i], batch.positions[i], batch.owners[i], batch.radii2[i]))
            .collect()
    }

    /// Interns all points of a batch none of which is at home here, in order.
    pub fn receive_all(&mut self, batch: &PointBatch<P>) -> Vec<u32> {
        (0..batch.len())
            .map(|i| {
                let (at, _) = self.receive(batch.ids[i], batch.positions[i], batch.owners[i]);
                self.radii2[at as usize] = batch.radii2[i];
                at
            })
            .collect()
    }

    /// The local number of a point that is here.
    pub fn find(&self, id: u64) -> Option<u32> {
        self.ghosts.get(&id).copied().or_else(|| self.find_owned(id))
    }

    /// Is this point at home here?
    #[inline]
    pub fn is_owned(&self, at: u32) -> bool {
        at < self.owned
    }

    /// The local numbers of the few home points among `ids`, by one look at all.
    pub fn owned_among(&self, ids: &[u64]) -> Vec<u32> {
        let own = &self.ids[..self.owned as usize];
        own.iter().zip(0u32..).filter(|(id, _)| ids.contains(id)).map(|(_, i)| i).collect()
    }

    /// Appends a point of the table to a batch.
    pub fn export(&self, at: u32, batch: &mut PointBatch<P>) {
        let i = at as usize;
        let radius2 = self.radii2.get(i).copied().unwrap_or(f64::INFINITY);
        batch.push(self.ids[i], self.positions[i], self.owners[i], radius2);
    }

    /// Points without balls.
    pub(crate) fn points(&self, numbers: &[u32]) -> PointBatch<P> {
        let each = || numbers.iter().map(|&i| i as usize);
        PointBatch {
            ids: Bulk(each().map(|i| self.ids[i]).collect()),
            positions: Bulk(each().map(|i| self.positions[i]).collect()),
            owners: Bulk(each().map(|i| self.owners[i]).collect()),
            radii2: Bulk(vec![f64::INFINITY; numbers.len()]),
        }
    }
}
