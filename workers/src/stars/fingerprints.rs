//! Hashes of cells, and their sums over stars. [`crate::stars::check`] has the statement.

use septet_geometry::complex::INFINITE;
use septet_geometry::point::Point;

use crate::direct::subdomain_triangulation::SubdomainTriangulation;
use crate::stars::fingerprint_sums::{
    BUCKETS, PairSum, RemoteSums, Sums, VertexSums, bucket_of, mix, point_hash,
};
use crate::stars::owned::StarsView;
use crate::state::cells::{smallest_vertex, star_cell};
use crate::state::table::Table;

impl Sums {
    /// Scans a subdomain triangulation and sums its pairs with ghosts. Pairs of two owned vertices agree by construction and
    /// are not summed.
    pub(super) fn of_subdomain<P: Point>(
        triangulation: &mut SubdomainTriangulation<P>,
        table: &Table<P>,
    ) -> Self {
        let (mut sums, mut remote) = (Sums::default(), RemoteSums::default());
        triangulation.scan(table.positions(), |cell, smallest| {
            let vertices = cell.as_ref();
            let hash_of = |v: u32| point_hash(table.ids()[v as usize], table.positions()[v as usize]);
            let hash = mix(vertices.iter().fold(0u128, |sum, &v| sum.wrapping_add(hash_of(v))));
            for &other in vertices {
                let ghost = match (table.is_owned(smallest), table.is_owned(other)) {
                    (true, false) => other,
                    (false, true) => smallest,
                    _ => continue,
                };
                remote.add_pair(&mut sums, table.owners()[ghost as usize], hash);
            }
        });
        remote.finish(&mut sums);
        sums
    }
}

/// A finite cell of a star, with the data that the sums need.
struct StarCell<'a, P: Point> {
    facet: &'a P::Facet,
    smallest: u32,
    hash: u128,
}

impl<P: Point> StarsView<'_, P> {
    /// Adds the pairs of some facets of the star of `vertex` to the sums, and to the sums of their smallest vertices.
    pub(super) fn add_facets(
        &self,
        vertex: u32,
        facets: &[P::Facet],
        sums: &mut Sums,
        vertex_sums: Option<&VertexSums>,
    ) {
        let table = self.table();
        let (mut from_smallest, mut from_other) = (PairSum::default(), PairSum::default());
        let mut terms = [0u64; BUCKETS];
        let mut remote = RemoteSums::default();
        let mut add_remote = |ghost: u32, hash: u128| {
            remote.add_pair(sums, table.owners()[ghost as usize], hash);
        };
        self.each_cell(vertex, facets, |StarCell { facet, smallest, hash }| {
            if smallest == vertex {
                for &other in facet.as_ref() {
                    if table.is_owned(other) {
                        from_smallest.add_pair(hash);
                        let term = &mut terms[bucket_of(hash)];
                        *term = term.wrapping_add(hash as u64);
                    } else {
                        add_remote(other, hash);
                    }
                }
            } else if table.is_owned(smallest) {
                if let Some(vertex_sums) = vertex_sums {
                    vertex_sums.subtract(smallest, hash);
                }
                from_other.add_pair(hash);
            } else {
                add_remote(smallest, hash);
            }
        });
        remote.finish(sums);
        sums.add_owned(from_smallest, from_other);
        if let Some(vertex_sums) = vertex_sums {
            vertex_sums.add(vertex, terms);
        }
    }

    /// Calls `f` with the finite cells of some facets of a star.
    #[inline]
    fn each_cell(&self, vertex: u32, facets: &[P::Facet], mut f: impl FnMut(StarCell<'_, P>)) {
        let (hashes, firsts) = self.stars().hashes().columns();
        let firsts = &firsts[..hashes.len()];
        let positions = self.table().positions();
        'facets: for facet in facets {
            let mut sum = hashes[vertex as usize];
            for &v in facet.as_ref() {
                let Some(&hash) = hashes.get(v as usize) else {
                    assert_eq!(v, INFINITE, "every vertex is in the table");
                    continue 'facets;
                };
                sum = sum.wrapping_add(hash);
            }
            let cell = star_cell::<P>(vertex, facet);
            let smallest = smallest_vertex(positions, cell.as_ref(), |v| firsts[v as usize]);
            f(StarCell { facet, smallest, hash: mix(sum) });
        }
    }
}
