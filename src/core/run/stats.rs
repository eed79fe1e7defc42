//! The numbers of the triangulation of a run, by one process or several.
//!
//! A process measures the cells of its shares. It sends the incidences of a vertex to the process that owns the vertex, which finds
//! its degree. All processes add up the parts. The messages are no part of the machine and are not counted.

use septet_meshing::quality::histogram::Histogram;
use septet_protocol::wire::{Alone, Parcel, Processes, WireError};
use septet_workers::config::cores::sort_rows;

use crate::result::outcome::Outcome;
use crate::result::share::WorkerShare;
use crate::result::stats::{HULL_FACET, Measured, PlacedShare, Stats, degree, degrees, hull_of};

impl Outcome {
    /// Returns the numbers of the triangulation, given the coordinates of all points of the input, `space` for each point. Returns
    /// `None` if this process does not have all shares, if the coordinates are those of other points, or in more than three
    /// dimensions.
    ///
    /// ```
    /// // Nine points of a grid: eight triangles, half a unit square each.
    /// let grid: Vec<[f64; 2]> = (0..9).map(|i| [f64::from(i % 3), f64::from(i / 3)]).collect();
    /// let run = septet_core::triangulate(&grid, &Default::default())?;
    /// let stats = run.stats(grid.as_flattened()).expect("all points");
    /// assert_eq!((stats.points, stats.edges, stats.cells), (9, 16, 8));
    /// assert_eq!((stats.volume, stats.surface, stats.hull_vertices), (4.0, 8.0, 8));
    /// assert_eq!(stats.shapes.least_angles.percentile(50), Some(45.0));
    /// # Ok::<(), septet_core::Error>(())
    /// ```
    pub fn stats(&self, coordinates: &[f64]) -> Option<Stats> {
        if self.space > 3
            || !self.is_whole()
            || coordinates.len() as u64 != self.points.input * self.space as u64
        {
            return None;
        }
        shared_stats(&mut Processes::over(&mut Alone), self, coordinates).ok()
    }
}

/// What the processes add up.
#[derive(Clone, Debug)]
struct Sums {
    measured: Measured,
    degrees: Histogram,
    /// The sum of all degrees.
    ends: u64,
    hull_vertices: u64,
    /// The least and the largest coordinates.
    extent: [[f64; 3]; 2],
}

/// Returns the numbers of the triangulation of all processes, on each of them. `coordinates` are those of the points that this
/// process read. Shares of several processes must have neighbours, as after [`crate::triangulate`].
///
/// # Errors
/// Fails on all processes if one of them is gone, or if its words do not fit.
pub fn shared_stats(
    processes: &mut Processes<'_>,
    run: &Outcome,
    coordinates: &[f64],
) -> Result<Stats, WireError> {
    let space = run.space;
    let shares: Vec<PlacedShare<'_>> =
        run.shares.iter().map(|share| placed(share, coordinates, space)).collect();
    let mut measured = Measured::default();
    for share in &shares {
        measured.merge(&share.measure());
    }
    let mut hull = Vec::new();
    if shares.iter().any(|placed| placed.share.cell_count() > 0 && !placed.share.has_neighbours()) {
        let (facets, vertices) = hull_of(&shares);
        measured.merge(&facets);
        hull = vertices;
    }
    let incidences = gathered(processes, run, &shares, &hull)?;
    let mut own =
        Sums { measured, degrees: degrees(), ends: 0, hull_vertices: 0, extent: extent(coordinates, space) };
    for count in incidences {
        let degree = degree(space, count);
        own.degrees.add(degree as f64);
        own.ends += degree;
        own.hull_vertices += u64::from(count >= HULL_FACET);
    }
    let mut words = Vec::new();
    own.append_to(&mut words);
    let mut parts = Vec::new();
    for (process, words) in (0..).zip(processes.all_gather(&words)?) {
        let corrupt = || WireError::Corrupt { process, reason: "its sums do not fit".to_owned() };
        parts.push(Sums::read_from(&mut words.into_iter()).ok_or_else(corrupt)?);
    }
    let mut all = parts.swap_remove(0);
    for part in &parts {
        all.merge(part);
    }
    Ok(all.stats(run))
}

/// Returns a share with the places of its points.
fn placed<'a>(share: &'a WorkerShare, coordinates: &'a [f64], space: usize) -> PlacedShare<'a> {
    let is_own = !share.coordinates.is_empty();
    let coordinates = if is_own { &share.coordinates } else { coordinates };
    PlacedShare { share, coordinates, is_own, space }
}

/// Returns the incidences of all vertices that this process owns. `hull` are the vertices of hull facets that shares do not know.
fn gathered(
    processes: &mut Processes<'_>,
    run: &Outcome,
    shares: &[PlacedShare<'_>],
    hull: &[u64],
) -> Result<Vec<u64>, WireError> {
    let own = processes.process();
    let mut to_each: Vec<Vec<u64>> = vec![Vec::new(); processes.processes() as usize];
    for placed in shares {
        let share = placed.share;
        for (at, (id, count)) in share.ids.iter().zip(placed.incidences()).enumerate() {
            // A vertex of this worker counts even if no cell of the worker has it.
            let is_hidden = || run.left_out.hidden.binary_search(id).is_ok();
            if count == 0 && (at >= share.owned || is_hidden()) {
                continue;
            }
            let process = share.owners.get(at).map_or(own, |&rank| run.placement.process_of(rank));
            if let Some(words) = to_each.get_mut(process as usize) {
                words.extend([*id, count]);
            }
        }
    }
    to_each[own as usize].extend(hull.iter().flat_map(|&id| [id, HULL_FACET]));
    let mut rows = std::mem::take(&mut to_each[own as usize]);
    let sent = (0..).zip(&to_each).filter(|(process, _)| *process != own);
    let sent = sent.map(|(process, words)| Parcel { process, bytes: bytemuck::cast_slice(words).to_vec() });
    for Parcel { process, bytes } in processes.scatter(sent.collect())? {
        if bytes.len() % 16 != 0 {
            return Err(WireError::Corrupt { process, reason: "its rows are not whole".to_owned() });
        }
        rows.extend(bytemuck::pod_collect_to_vec::<u8, u64>(&bytes));
    }
    sort_rows(&mut rows, 2);
    let same = |a: &[u64; 2], b: &[u64; 2]| a[0] == b[0];
    let groups = rows.as_chunks::<2>().0.chunk_by(same);
    Ok(groups.map(|group| group.iter().map(|row| row[1]).sum()).collect())
}

/// Returns the least and the largest coordinates of finite points.
fn extent(coordinates: &[f64], space: usize) -> [[f64; 3]; 2] {
    let mut ends = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for point in coordinates.chunks_exact(space).filter(|point| point.iter().all(|x| x.is_finite())) {
        for (axis, x) in point.iter().enumerate() {
            // Adding 0.0 removes the sign of zero.
            ends[0][axis] = ends[0][axis].min(x + 0.0);
            ends[1][axis] = ends[1][axis].max(x + 0.0);
        }
    }
    ends
}

impl Sums {
    fn merge(&mut self, other: &Sums) {
        self.measured.merge(&other.measured);
        self.degrees.merge(&other.degrees);
        self.ends += other.ends;
        self.hull_vertices += other.hull_vertices;
        for axis in 0..3 {
            self.extent[0][axis] = self.extent[0][axis].min(other.extent[0][axis]);
            self.extent[1][axis] = self.extent[1][axis].max(other.extent[1][axis]);
        }
    }

    fn append_to(&self, words: &mut Vec<u64>) {
        self.measured.append_to(words);
        self.degrees.append_to(words);
        words.extend([self.ends, self.hull_vertices]);
        words.extend(self.extent.as_flattened().iter().map(|x| x.to_bits()));
    }

    fn read_from(words: &mut impl Iterator<Item = u64>) -> Option<Self> {
        let measured = Measured::read_from(words)?;
        let degrees = degrees().read_from(words)?;
        let (ends, hull_vertices) = (words.next()?, words.next()?);
        let mut extent = [[0.0; 3]; 2];
        for x in extent.as_flattened_mut() {
            *x = f64::from_bits(words.next()?);
        }
        Some(Sums { measured, degrees, ends, hull_vertices, extent })
    }

    fn stats(self, run: &Outcome) -> Stats {
        let Measured { shapes, surface, hull_facets } = self.measured;
        let (space, cells, edges) = (run.space, run.facts.cells, self.ends / 2);
        let sides = space as u64 + 1;
        Stats {
            space,
            points: run.points.used,
            duplicates: run.points.duplicate,
            edges,
            facets: u64::midpoint(sides * cells, hull_facets),
            cells,
            components: u64::from(cells > 0),
            hull_facets,
            hull_edges: if space == 2 { hull_facets } else { 3 * hull_facets / 2 },
            hull_vertices: self.hull_vertices,
            extent: (0..space)
                .map(|axis| [self.extent[0][axis], self.extent[1][axis]])
                .filter(|[low, high]| low <= high)
                .collect(),
            volume: shapes.volume.value(),
            surface: surface.value(),
            degrees: self.degrees,
            shapes,
        }
    }
}

#[cfg(test)]
mod tests;
