//! The agreement of pieces: every point and cell has one owner, and each ghost equals the point or cell of its owner.
//!
//! **Statement.** Let the following hold. (1) In a piece, the ids of its own points ascend, and its own cells are numbered
//! after those of the pieces before it. Each own point is a vertex, if there are cells. (2) Each id belongs to one piece,
//! and has the same coordinates in all. (3) A cell belongs to the piece of its lexicographically smallest vertex. (4) The
//! ghost cells of a piece are exactly the cells of other pieces that have a vertex of the piece. Then the cells that are
//! not ghosts are those of one mesh, and every point that is not a ghost has all its cells in its piece.
//!
//! **Source.** The description of `.pvtu` files in the guide, section "Pieces of workers".
//!
//! **Work.** O(m log m) for m points and cells of all pieces.

use glam::DVec3;

use super::piece::Piece;
use crate::read::error::{InputError, shown};

/// The points of all pieces, and their places in each piece.
pub struct Agreed {
    /// The global ids, ascending.
    pub ids: Vec<u64>,
    /// The coordinates of each id.
    pub places: Vec<DVec3>,
    /// For each piece, the position among `ids` of each of its points.
    pub positions: Vec<Vec<u64>>,
}

/// Returns the error of a piece that does not agree with the others.
fn differs(piece: &Piece, what: impl Into<String>) -> InputError {
    InputError::Pieces { path: piece.path.clone(), what: what.into() }
}

/// Compares the pieces.
pub fn check(pieces: &[Piece]) -> Result<Agreed, InputError> {
    let mut first_cell = 0;
    for (worker, piece) in (1..).zip(pieces) {
        check_order(piece, first_cell)?;
        check_owners(piece, worker)?;
        check_use(piece)?;
        first_cell += piece.owned_cells().count() as u64;
    }
    let (agreed, owners) = check_points(pieces)?;
    check_cells(pieces, &agreed, &owners)?;
    Ok(agreed)
}

/// Checks that the ids of own points ascend, and that own cells are numbered from `first_cell`.
fn check_order(piece: &Piece, first_cell: u64) -> Result<(), InputError> {
    let own = piece.ids.iter().zip(&piece.ghost_points).filter(|(_, ghost)| !**ghost);
    let mut before = None;
    for (&id, _) in own {
        if let Some(before) = before.filter(|before| *before >= id) {
            return Err(differs(
                piece,
                format!("the ids of its points do not ascend: {id} follows {before}"),
            ));
        }
        before = Some(id);
    }
    let Some(ids) = &piece.cell_ids else { return Ok(()) };
    for ((at, _), expected) in piece.owned_cells().zip(first_cell..) {
        if ids[at] != expected {
            let what = format!("its cell {at} has the number {}, and not {expected}", ids[at]);
            return Err(differs(piece, what));
        }
    }
    Ok(())
}

/// Checks that own cells name this worker as their owner.
fn check_owners(piece: &Piece, worker: u64) -> Result<(), InputError> {
    let Some(owners) = &piece.owners else { return Ok(()) };
    match piece.owned_cells().find(|(at, _)| owners[*at] != worker) {
        Some((at, _)) => {
            let what = format!("its cell {at} belongs to worker {}, and not to worker {worker}", owners[at]);
            Err(differs(piece, what))
        }
        None => Ok(()),
    }
}

/// Checks that every own point is a vertex, if the piece has cells.
fn check_use(piece: &Piece) -> Result<(), InputError> {
    let mut is_used = vec![piece.is_empty(); piece.ids.len()];
    piece.cells.iter().for_each(|&vertex| is_used[vertex as usize] = true);
    match is_used.iter().zip(&piece.ghost_points).position(|(used, ghost)| !used && !ghost) {
        Some(at) => Err(differs(piece, format!("its point {at} (id {}) is in no cell", piece.ids[at]))),
        None => Ok(()),
    }
}

/// A point of a piece: id, whether it is a ghost, the piece, and the position in it.
type Entry = (u64, bool, usize, usize);

/// Finds the owner of each id, and compares the coordinates of its ghosts. Returns the points, and the piece that owns each.
fn check_points(pieces: &[Piece]) -> Result<(Agreed, Vec<usize>), InputError> {
    let of = |(number, piece): (usize, &Piece)| -> Vec<Entry> {
        let points = piece.ids.iter().zip(&piece.ghost_points).enumerate();
        points.map(|(at, (&id, &ghost))| (id, ghost, number, at)).collect()
    };
    let mut entries: Vec<Entry> = pieces.iter().enumerate().flat_map(of).collect();
    entries.sort_unstable();
    let positions = pieces.iter().map(|piece| vec![0; piece.ids.len()]).collect();
    let mut agreed = Agreed { ids: Vec::new(), places: Vec::new(), positions };
    let mut owners = Vec::new();
    for same in entries.chunk_by(|a, b| a.0 == b.0) {
        let (id, is_ghost, owner, at) = same[0];
        if is_ghost {
            return Err(differs(&pieces[owner], format!("its ghost point {at} (id {id}) has no owner")));
        }
        check_copies(pieces, same)?;
        for &(_, _, piece, at) in same {
            agreed.positions[piece][at] = agreed.ids.len() as u64;
        }
        agreed.ids.push(id);
        agreed.places.push(pieces[owner].places[at]);
        owners.push(owner);
    }
    Ok((agreed, owners))
}

/// Compares the points of one id. The first one is the owner's.
fn check_copies(pieces: &[Piece], same: &[Entry]) -> Result<(), InputError> {
    let (id, _, owner, own) = same[0];
    let by = shown(&pieces[owner].path);
    for pair in same.windows(2) {
        let ((_, _, before, _), (_, is_ghost, piece, at)) = (pair[0], pair[1]);
        let what = if !is_ghost {
            format!("it owns its point {at} (id {id}), which {by} owns")
        } else if piece == before {
            format!("the id {id} occurs twice in it")
        } else if pieces[piece].places[at] != pieces[owner].places[own] {
            format!("its ghost point {at} (id {id}) has other coordinates than in {by}, which owns it")
        } else {
            continue;
        };
        return Err(differs(&pieces[piece], what));
    }
    Ok(())
}

/// A cell that is a ghost of a piece: the piece, and its vertices. A triangle ends with [`NO_VERTEX`].
type Ghost = (usize, [u64; 4]);

/// The place of a missing fourth vertex.
const NO_VERTEX: u64 = u64::MAX;

/// The piece and the position in it of the cell that an entry describes.
type Origin = (usize, usize);

/// Checks the owner of each cell, and compares the ghost cells with the cells of their owners.
fn check_cells(pieces: &[Piece], agreed: &Agreed, owners: &[usize]) -> Result<(), InputError> {
    let (mut expected, mut found): (Vec<(Ghost, Origin)>, Vec<(Ghost, Origin)>) = (Vec::new(), Vec::new());
    for (number, piece) in pieces.iter().enumerate() {
        for (at, cell) in piece.all_cells() {
            let mut row = [NO_VERTEX; 4];
            for (vertex, &of_piece) in row.iter_mut().zip(cell) {
                *vertex = agreed.positions[number][of_piece as usize];
            }
            let vertices = &row[..cell.len()];
            if piece.ghost_cells[at] {
                found.push(((number, row), (number, at)));
                continue;
            }
            check_smallest(pieces, (agreed, owners), (number, at), vertices)?;
            let mut others: Vec<usize> = vertices.iter().map(|&vertex| owners[vertex as usize]).collect();
            others.sort_unstable();
            others.dedup();
            let others = others.into_iter().filter(|other| *other != number);
            expected.extend(others.map(|other| ((other, row), (number, at))));
        }
    }
    expected.sort_unstable();
    found.sort_unstable();
    compare(pieces, &expected, &found)
}

/// Checks that a cell belongs to the piece of its lexicographically smallest vertex.
fn check_smallest(
    pieces: &[Piece],
    (agreed, owners): (&Agreed, &[usize]),
    (number, at): Origin,
    vertices: &[u64],
) -> Result<(), InputError> {
    let key = |vertex: u64| agreed.places[vertex as usize].to_array();
    let smaller = |a: u64, b: u64| {
        if key(b).partial_cmp(&key(a)).is_some_and(std::cmp::Ordering::is_lt) { b } else { a }
    };
    let smallest = vertices.iter().copied().reduce(smaller);
    match smallest.map(|vertex| owners[vertex as usize]).filter(|owner| *owner != number) {
        Some(owner) => {
            let other = shown(&pieces[owner].path);
            Err(differs(&pieces[number], format!("it owns its cell {at}, which belongs to {other}")))
        }
        None => Ok(()),
    }
}

/// Compares sorted lists of ghost cells: those that follow from the cells of the owners, and those of the pieces.
fn compare(
    pieces: &[Piece],
    expected: &[(Ghost, Origin)],
    found: &[(Ghost, Origin)],
) -> Result<(), InputError> {
    for place in 0..expected.len().max(found.len()) {
        let (wanted, got) = (expected.get(place), found.get(place));
        match (wanted, got) {
            (Some((wanted, origin)), Some((got, own))) if wanted == got => {
                check_labels(pieces, *origin, *own)?;
            }
            (Some((wanted, (owner, at))), got) if got.is_none_or(|(got, _)| wanted < got) => {
                let by = shown(&pieces[*owner].path);
                let what = format!("cell {at} of {by} is no ghost cell of it, although it owns a vertex");
                return Err(differs(&pieces[wanted.0], what));
            }
            (_, Some((_, (piece, at)))) => {
                let what = format!("its ghost cell {at} is no cell of another piece that has a vertex of it");
                return Err(differs(&pieces[*piece], what));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Compares the number and the worker of a ghost cell with those of the cell of its owner.
fn check_labels(pieces: &[Piece], (owner, at): Origin, (piece, ghost): Origin) -> Result<(), InputError> {
    let (of, own) = (&pieces[owner], &pieces[piece]);
    let labels = [("number", &own.cell_ids, &of.cell_ids), ("worker", &own.owners, &of.owners)];
    for (label, found, expected) in labels {
        if let (Some(found), Some(expected)) = (found, expected)
            && found[ghost] != expected[at]
        {
            let by = shown(&of.path);
            let what = format!(
                "the {label} of its ghost cell {ghost} is {}, and in {by}, which owns it, {}",
                found[ghost], expected[at]
            );
            return Err(differs(own, what));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    /// A square of two triangles. The first piece owns points 0 and 1, the second one points 2 and 3.
    fn square() -> Vec<Piece> {
        let place = |id: u64| DVec3::new((id & 1) as f64, (id >> 1) as f64, 0.0);
        let piece = |name: &str, ids: [u64; 4], cells: [[u64; 3]; 2], numbers: [u64; 2]| Piece {
            path: PathBuf::from(name),
            dimension: 2,
            ids: ids.to_vec(),
            ghost_points: vec![false, false, true, true],
            places: ids.map(place).to_vec(),
            cells: cells.as_flattened().to_vec(),
            ghost_cells: vec![false, true],
            cell_ids: Some(numbers.to_vec()),
            owners: Some(numbers.map(|number| number + 1).to_vec()),
            notes: Vec::new(),
        };
        vec![
            piece("a.vtu", [0, 1, 2, 3], [[0, 1, 2], [1, 3, 2]], [0, 1]),
            piece("b.vtu", [2, 3, 0, 1], [[3, 1, 0], [2, 3, 0]], [1, 0]),
        ]
    }

    #[test]
    fn pieces_that_agree_have_one_mesh() {
        let agreed = check(&square()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(agreed.ids, [0, 1, 2, 3]);
        assert_eq!(agreed.positions, [[0, 1, 2, 3], [2, 3, 0, 1]]);
        assert_eq!(agreed.places[3], DVec3::new(1.0, 1.0, 0.0));
        assert!(check(&[]).is_ok_and(|agreed| agreed.ids.is_empty()));
    }

    #[test]
    fn a_difference_names_the_piece() {
        type Alter = fn(&mut [Piece]);
        let alterations: [(Alter, &str, &str); 13] = [
            (|p| p[1].places[2].x = 0.5, "b.vtu", "other coordinates than in a.vtu"),
            (|p| p[0].places[0].x = -0.5, "b.vtu", "other coordinates than in a.vtu"),
            (|p| p[0].ids.swap(0, 1), "a.vtu", "do not ascend: 0 follows 1"),
            (|p| p[1].ids[3] = 7, "b.vtu", "(id 7) has no owner"),
            (|p| p[1].ids[3] = 0, "b.vtu", "the id 0 occurs twice"),
            (|p| p[1].ghost_points[2] = false, "b.vtu", "do not ascend"),
            (|p| p[0].ghost_points[3] = false, "b.vtu", "which a.vtu owns"),
            (|p| p[0].cell_ids = Some(vec![1, 0]), "a.vtu", "has the number 1, and not 0"),
            (|p| p[0].cell_ids = Some(vec![0, 2]), "a.vtu", "the number of its ghost cell 1 is 2"),
            (|p| p[0].owners = Some(vec![2, 2]), "a.vtu", "belongs to worker 2, and not to worker 1"),
            (|p| p[0].owners = Some(vec![1, 1]), "a.vtu", "the worker of its ghost cell 1 is 1"),
            (|p| p[0].cells.swap(3, 4), "a.vtu", "ghost cell"),
            (
                |p| {
                    p[1].cells.truncate(3);
                    p[1].ghost_cells.truncate(1);
                },
                "b.vtu",
                "cell 0 of a.vtu is no ghost cell of it",
            ),
        ];
        for (alter, path, words) in alterations {
            let mut pieces = square();
            alter(&mut pieces);
            let error = check(&pieces).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.starts_with(path) && error.contains(words), "{path}, {words}: {error}");
        }
    }

    #[test]
    fn cells_belong_to_the_piece_of_their_smallest_vertex() {
        let mut pieces = square();
        for piece in &mut pieces {
            piece.cell_ids = None;
            piece.owners = None;
            piece.ghost_cells.reverse();
        }
        let error = check(&pieces).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains("it owns its cell 1, which belongs to b.vtu"), "{error}");
    }
}
