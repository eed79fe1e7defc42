//! Readers of files of points, cells, domains and sizes.
//!
//! A reader takes the whole file as bytes. It checks every announced count against the size of the file. It returns the
//! content of the file, or an [`InputError`] with the file, the location and a remedy. Readers do not print. Everything
//! that they ignore is reported in notes.
//!
//! Several processes can read parts of files ([`read_shared`]).

mod apart;
mod array;
mod axes;
mod before;
mod breaklines;
mod cells;
mod chemistry;
mod collect;
mod columns;
mod dispatch;
mod domain;
mod domain_file;
mod error;
mod faces;
mod foreign;
mod formats;
mod head;
mod header;
mod ids;
mod list;
mod listed;
mod load;
mod mesh;
mod mesh_sizes;
mod offsets;
mod points;
mod raw_rows;
mod reading;
mod row;
mod scalar;
mod several;
mod shared;
mod signature;
mod size_rows;
mod sizes;
mod terrain;
#[cfg(test)]
mod tests;
mod text;
mod utf16;
mod weight_file;
mod weight_rows;
mod weights;

pub use apart::apart;
pub use breaklines::read_breaklines;
pub use cells::{CellFile, CellOptions};
pub use dispatch::{read, read_cells, read_cells_from, read_from, read_mesh};
pub use domain::{AnyInput, DomainFile};
pub use domain_file::read_domain;
pub use error::{InputError, Place, WeightError, WeightFault};
pub use list::{EntryFault, FileList, ListError, PointList, read_list};
pub use listed::ListedFile;
pub use offsets::read_offsets;
pub use points::{Column, CoordinateType, PointFile, ReadOptions, ReadProgress};
pub use raw_rows::{RawRows, UnknownRawRows};
pub use reading::{Extent, FileReading, OtherLines};
pub use several::read_domains;
pub use shared::{SharedPoints, WHOLE_LIMIT, read_shared, share_points};
pub use sizes::read_sizes;
pub use weights::{WeightOption, WeightSource};
