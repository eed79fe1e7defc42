//! VTK XML unstructured grids, `.vtu`, and polygons, `.vtp`, of one piece. Arrays are inline ASCII or base64, or appended raw or base64.
//! Binary arrays may be compressed with zlib.

mod arrays;
mod base64;
mod decode;
mod grid;
mod pieces;
mod sizes;
mod xml;

pub use grid::parse;
pub use pieces::{read_both, read_cells as read_cells_of_pieces};
pub use sizes::read_sizes;

/// Whether the bytes are a VTK XML file, and whether it has this type.
pub fn is_of_type(data: &[u8], is_wanted: fn(&str) -> bool) -> bool {
    const HEAD: usize = 1 << 12;
    let head = &data[..data.len().min(HEAD)];
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    (text.starts_with(b"<?xml") || text.starts_with(b"<VTKFile"))
        && arrays::first_tag(head, b"VTKFile")
            .is_some_and(|root| is_wanted(root.attribute("type").unwrap_or_default()))
}
