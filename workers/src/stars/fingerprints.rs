//! Hashes of cells, and their sums over stars ([`crate::stars::check`] has the statement).

use septet_geometry::complex::INFINITE;
use septet_geometry::point::Point;

use crate::direct::subdomain_triangulation::SubdomainTriangulation;
use crate::stars::fingerprint_sums::{
    RecentHashes, RemoteSums, SHARES, ShortSums, Sums, join, mix, point_hash, share_of,
};
use crate::stars::owned::{Chart, Stars};
use crate::state::cells::{Smallest, finite_cell, smallest_of};
use crate::state::table::Table;

impl<P: Point> Stars<P> {
    /// Hashes the points that came since the last time.
    pub(crate) fn extend_hashes(&mut self, table: &Table<P>) {
        let known = self.hashes.len();
        let new = table.ids()[known..].iter().zip(&table.positions()[known..]);
        self.hashes.extend(new.map(|(&id, &x)| point_hash(id, x)));
        self.firsts.extend(table.positions()[known..].iter().map(|x| x.coord(0)));
    }

    /// Sums the cells of the piece, if the links are in one.
    pub(crate) fn sum_subdomain(&mut self, table: &Table<P>) -> bool {
        let Some(mut piece) = self.take_subdomain() else { return false };
        self.sums = sums_of_subdomain(&mut piece, table);
        self.set_subdomain(Some(piece));
        true
    }

    /// Follows the change of a home star: facets that are gone, and new ones.
    pub(crate) fn recount(&mut self, table: &Table<P>, owned: u32, gone: &[P::Facet], fresh: &[P::Facet]) {
        let mut sums = std::mem::take(&mut self.sums);
        let chart = Chart { table, stars: self };
        chart.sum_star(owned, gone, false, &mut sums, None);
        chart.sum_star(owned, fresh, true, &mut sums, None);
        self.sums = sums;
    }

    /// The hash of a cell.
    pub(crate) fn cell_hash(&self, cell: &P::Cell) -> u128 {
        mix(cell.as_ref().iter().fold(0u128, |s, &v| s.wrapping_add(self.hashes[v as usize])))
    }

    /// The key of a pair, as it is recorded.
    fn key(&self, cell_hash: u128, other: u32) -> u128 {
        mix(cell_hash ^ self.hashes[other as usize])
    }
}

/// The sums of a piece, which is surveyed: pairs both at home are in one triangulation and agree.
fn sums_of_subdomain<P: Point>(piece: &mut SubdomainTriangulation<P>, table: &Table<P>) -> Sums {
    let mut sums = Sums::default();
    let mut away = RemoteSums::new(true);
    // Such cells have few points, each in many cells that follow each other closely.
    let mut hashes = RecentHashes::of_points(table.positions().len());
    piece.scan(table.positions(), |cell, smallest| {
        let vertices = cell.as_ref();
        let mut sum = 0u128;
        for &v in vertices {
            let make = || point_hash(table.ids()[v as usize], table.positions()[v as usize]);
            sum = sum.wrapping_add(hashes.hash(v, make));
        }
        let whole = mix(sum);
        for &other in vertices {
            let far = match (table.is_owned(smallest), table.is_owned(other)) {
                (true, false) => other,
                (false, true) => smallest,
                _ => continue,
            };
            away.count(&mut sums, table.owners()[far as usize], whole);
        }
    });
    away.finish(&mut sums);
    sums
}

impl<P: Point> Chart<'_, P> {
    /// The lexicographically smallest vertex of a cell of local numbers.
    #[inline]
    pub(crate) fn smallest(&self, cell: &P::Cell) -> u32 {
        let (vertices, firsts) = (cell.as_ref(), self.stars.firsts.as_slice());
        let mut smallest = Smallest::of(vertices[0], firsts[vertices[0] as usize]);
        vertices[1..].iter().for_each(|&v| smallest.look(v, firsts[v as usize]));
        smallest.vertex(|| smallest_of(self.table.positions(), vertices.iter().copied()))
    }

    /// Calls `f` with the pairs of a star: key, and the other vertex.
    pub(crate) fn each_pair(&self, owned: u32, mut f: impl FnMut(u128, u32)) {
        for facet in self.stars.link(owned) {
            let Some(cell) = finite_cell::<P>(owned, facet) else { continue };
            let smallest = self.smallest(&cell);
            let hash = self.stars.cell_hash(&cell);
            if smallest == owned {
                facet.as_ref().iter().for_each(|&other| f(self.stars.key(hash, other), other));
            } else {
                f(self.stars.key(hash, owned), smallest);
            }
        }
    }

    /// Adds the pairs of one star to the sums, or takes them away; adds them to those of each home vertex.
    pub(crate) fn sum_star(
        &self,
        owned: u32,
        link: &[P::Facet],
        add: bool,
        sums: &mut Sums,
        short: Option<&ShortSums>,
    ) {
        let table = self.table;
        let (mut from_smallest, mut from_other) = ((0u128, 0u64), (0u128, 0u64));
        let mut shares = [0u64; SHARES];
        let mut away = RemoteSums::new(add);
        let mut elsewhere = |other: u32, hash: u128| away.count(sums, table.owners()[other as usize], hash);
        self.each_cell(owned, link, |facet, smallest, hash| {
            if smallest == owned {
                for &other in facet.as_ref() {
                    if table.is_owned(other) {
                        Sums::count(&mut from_smallest, hash);
                        let share = &mut shares[share_of(hash)];
                        *share = share.wrapping_add(hash as u64);
                    } else {
                        elsewhere(other, hash);
                    }
                }
            } else if table.is_owned(smallest) {
                if let Some(short) = short {
                    short.subtract(smallest, hash);
                }
                Sums::count(&mut from_other, hash);
            } else {
                elsewhere(smallest, hash);
            }
        });
        away.finish(sums);
        join(&mut sums.from_smallest, from_smallest, add);
        join(&mut sums.from_other, from_other, add);
        if let Some(short) = short {
            short.add(owned, shares);
        }
    }

    /// Calls `f` with the cells of a star: facet, smallest vertex, hash ([`Self::smallest`] and [`Stars::cell_hash`] in one
    /// look at each vertex).
    #[inline]
    fn each_cell(&self, owned: u32, link: &[P::Facet], mut f: impl FnMut(&P::Facet, u32, u128)) {
        let hashes = self.stars.hashes.as_slice();
        let firsts = &self.stars.firsts[..hashes.len()];
        let (own, first) = (hashes[owned as usize], firsts[owned as usize]);
        'facets: for facet in link {
            let (mut sum, mut smallest) = (own, Smallest::of(owned, first));
            for &v in facet.as_ref() {
                let Some(&hash) = hashes.get(v as usize) else {
                    assert_eq!(v, INFINITE, "a vertex stands in the table");
                    continue 'facets;
                };
                sum = sum.wrapping_add(hash);
                smallest.look(v, firsts[v as usize]);
            }
            let vertices = || std::iter::once(owned).chain(facet.as_ref().iter().copied());
            f(facet, smallest.vertex(|| smallest_of(self.table.positions(), vertices())), mix(sum));
        }
    }
}
