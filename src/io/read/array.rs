//! Arrays of numbers in binary files: the rows of `.npy` files and of raw files.

use super::collect::{Collector, MOST_COORDINATES};
use super::error::{InputError, Place};
use super::points::{CoordinateType, PointFile, ReadOptions};
use super::scalar::{Endian, Scalar};
use super::text::Source;
use super::weight_rows::WeightRows;

/// The place and the type of a two-dimensional array in a file.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    /// The type of the numbers.
    pub scalar: Scalar,
    /// The byte order of the numbers.
    pub endian: Endian,
    /// The number of rows.
    pub rows: u64,
    /// The number of columns.
    pub columns: usize,
    /// The 0-based column of the weights, which are no coordinates, if the array has them.
    pub weight: Option<usize>,
    /// Whether columns are contiguous (Fortran order).
    pub fortran: bool,
    /// The offset of the data in the file.
    pub start: u64,
    /// The number of bytes after the data.
    pub surplus: u64,
    /// The columns in rows of fields of several types, or `None` if all columns have the type of the array.
    pub fields: Option<Fields>,
}

/// The columns in rows of fields.
#[derive(Clone, Copy)]
pub(super) struct Fields {
    /// The number of bytes of a row.
    pub stride: usize,
    /// The coordinates and then the weights, as many as the layout has columns.
    pub of: [Field; 4],
    /// The number of other fields.
    pub ignored: usize,
}

/// A number in a row.
#[derive(Clone, Copy)]
pub(super) struct Field {
    /// The offset in the row.
    pub offset: usize,
    /// The type of the number.
    pub scalar: Scalar,
    /// The byte order of the number.
    pub endian: Endian,
}

/// Returns the advice for an array of this many rows that has no columns of coordinates.
pub(super) fn shape_advice(rows: u64) -> &'static str {
    if matches!(rows, 2 | 3) {
        "it is transposed: save rows of points with numpy.save(name, a.T)"
    } else {
        "save only the columns of the coordinates (supported: 2 to 6)"
    }
}

/// Rows of an array, which borrow their bytes.
pub(super) struct Array<'a> {
    pub layout: Layout,
    /// The number of rows.
    pub rows: usize,
    /// The offset of the bytes in the file.
    pub start: u64,
    /// The bytes of the rows.
    data: &'a [u8],
}

impl Layout {
    /// Returns the type of the coordinates. Coordinates of several types are doubles.
    pub fn coordinate_type(&self) -> CoordinateType {
        let Some(fields) = self.fields else { return self.scalar.coordinate_type() };
        let mut types = fields.of.iter().take(self.coordinates()).map(|field| field.scalar.coordinate_type());
        let first = types.next().unwrap_or(CoordinateType::Float64);
        if types.all(|other| other == first) { first } else { CoordinateType::Float64 }
    }

    /// Returns the number of columns of coordinates.
    fn coordinates(&self) -> usize {
        self.columns - usize::from(self.weight.is_some())
    }

    /// Returns the number of bytes of a row.
    pub fn row_size(&self) -> u64 {
        self.fields.map_or(self.columns * self.scalar.size(), |fields| fields.stride) as u64
    }

    /// Creates a collector for `rows` points, or refuses an array of other than two to six columns of coordinates.
    pub fn collector<'a>(
        &self,
        source: Source<'a>,
        options: &ReadOptions,
        rows: u64,
    ) -> Result<Collector<'a>, InputError> {
        let place = Place::Byte(self.start);
        let found = self.coordinates();
        let drops_columns = found > 3 && options.dimension.is_some_and(|dimension| dimension < found);
        if !(2..=MOST_COORDINATES).contains(&found) || drops_columns {
            return Err(self.wrong_shape(source, place));
        }
        // Only an array has a dimension above 3 without a word about it.
        let stated = options.dimension.or((found > 3).then_some(found));
        let options = &ReadOptions { dimension: stated, ..options.clone() };
        // No header announces more rows than the file has.
        let bytes = usize::try_from(rows.saturating_mul(self.row_size())).unwrap_or(usize::MAX);
        let size = (rows, bytes, self.row_size() as usize);
        let mut points = Collector::new(source, options, (place, self.coordinates()), size)?;
        points.coordinate_type = Some(self.coordinate_type());
        Ok(points)
    }

    /// Returns `true` if the number of columns is the dimension above 3 of the points unless the last column is constant.
    pub fn may_be_homogeneous(&self, options: &ReadOptions) -> bool {
        self.coordinates() > 3 && options.dimension.is_none()
    }

    /// Refuses an array whose columns are the dimension if its last column is constant.
    fn refuse_homogeneous(
        &self,
        source: Source<'_>,
        options: &ReadOptions,
        points: &Collector<'_>,
    ) -> Result<(), InputError> {
        if !self.may_be_homogeneous(options) || !points.has_constant_end() {
            return Ok(());
        }
        let (path, place) = (source.path.to_owned(), Place::Byte(self.start));
        Err(InputError::Homogeneous { path, place, rows: self.rows, columns: self.columns })
    }

    /// Returns the error for an array of other than two to six columns of coordinates.
    fn wrong_shape(&self, source: Source<'_>, place: Place) -> InputError {
        let weights = if self.weight.is_some() { " with weights" } else { "" };
        let what = format!("an array of shape ({}, {}) as points{weights}", self.rows, self.columns);
        source.unsupported(place, what, shape_advice(self.rows))
    }

    /// Adds the points of whole rows in C order, which begin at offset `start` of the file. Returns the number of
    /// integers that were rounded.
    pub fn rows_at(&self, start: u64, data: &[u8], points: &mut Collector<'_>) -> Result<u64, InputError> {
        let rows = data.len() / (self.row_size() as usize).max(1);
        Array { layout: *self, rows, start, data }.add_to(points)
    }

    /// Adds the numbers of whole rows of one column, which begin at offset `start` of the file.
    pub fn numbers_at(&self, start: u64, data: &[u8], rows: &mut WeightRows<'_>) -> Result<(), InputError> {
        let count = data.len() / (self.row_size() as usize).max(1);
        let array = Array { layout: *self, rows: count, start, data };
        (0..count).try_for_each(|row| rows.push(array.place(row, 0), array.float(row, 0)))
    }

    /// Reads the points of all rows of a file.
    pub fn points(&self, source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
        let mut points = self.collector(source, options, self.rows)?;
        let rounded = Array::of(source, *self).add_to(&mut points)?;
        self.refuse_homogeneous(source, options, &points)?;
        points.notes.extend(self.notes(rounded));
        Ok(PointFile { rounded, ..points.finish() })
    }

    /// Returns the notes on an array with this number of rounded integers.
    pub fn notes(&self, rounded: u64) -> Vec<String> {
        let mut notes = Vec::new();
        if rounded > 0 {
            notes.push(format!("{rounded} integers are too large for a double and were rounded"));
        }
        if self.surplus > 0 {
            notes.push(format!("{} bytes after the array are ignored", self.surplus));
        }
        if let Some(Fields { ignored: ignored @ 1.., .. }) = self.fields {
            notes.push(format!("{ignored} further fields of each row are ignored"));
        }
        notes
    }
}

impl<'a> Array<'a> {
    /// Returns all rows of a file.
    pub fn of(source: Source<'a>, layout: Layout) -> Self {
        let data = &source.data[layout.start as usize..source.data.len() - layout.surplus as usize];
        Array { rows: layout.rows as usize, start: layout.start, data, layout }
    }

    /// Returns the bytes of all rows.
    pub fn bytes_of_rows(&self) -> &'a [u8] {
        self.data
    }

    /// Returns the number of bytes from an element to the next one of its column.
    fn step(&self) -> usize {
        let Layout { scalar, columns, fortran, fields, .. } = self.layout;
        match fields {
            Some(fields) => fields.stride,
            None if fortran => scalar.size(),
            None => columns * scalar.size(),
        }
    }

    /// Returns the type, the byte order and the offset of the first element of a column.
    fn column(&self, column: usize) -> Field {
        let Layout { scalar, endian, fortran, fields, .. } = self.layout;
        match fields {
            Some(fields) => fields.of[column],
            None if fortran => Field { offset: column * self.rows * scalar.size(), scalar, endian },
            None => Field { offset: column * scalar.size(), scalar, endian },
        }
    }

    /// Returns an element as a double.
    pub fn float(&self, row: usize, column: usize) -> f64 {
        let field = self.column(column);
        field.scalar.float(self.element(row, field), field.endian)
    }

    /// Returns an element as an integer.
    pub fn integer(&self, row: usize, column: usize) -> i128 {
        let field = self.column(column);
        field.scalar.integer(self.element(row, field), field.endian)
    }

    /// Returns the bytes of an element of a column.
    fn element(&self, row: usize, column: Field) -> &[u8] {
        self.bytes(row * self.step() + column.offset, column)
    }

    /// Returns the bytes of the element of a column at a position in the data.
    fn bytes(&self, at: usize, column: Field) -> &[u8] {
        &self.data[at..at + column.scalar.size()]
    }

    /// Returns the byte offset of an element in the file.
    pub fn offset(&self, row: usize, column: usize) -> u64 {
        self.start + (row * self.step() + self.column(column).offset) as u64
    }

    /// Returns the place of an element.
    pub fn place(&self, row: usize, column: usize) -> Place {
        Place::Byte(self.offset(row, column))
    }

    /// Adds all rows as points. Returns the number of integers that were rounded.
    fn add_to(&self, points: &mut Collector<'_>) -> Result<u64, InputError> {
        let mut rounded = 0_u64;
        let dimension = points.dimension();
        // The columns are the same for all rows.
        let weight = self.layout.weight;
        let of_points = (0..self.layout.columns).filter(|column| weight != Some(*column)).take(dimension);
        let columns: Vec<Field> = of_points.map(|column| self.column(column)).collect();
        let weight = weight.map(|column| self.column(column));
        let step = self.step();
        for row in 0..self.rows {
            let mut at = [0.0; MOST_COORDINATES];
            for (slot, column) in at.iter_mut().zip(&columns) {
                let element = self.bytes(row * step + column.offset, *column);
                *slot = column.scalar.float(element, column.endian);
                rounded += u64::from(column.scalar.rounds(element, column.endian));
            }
            // The first coordinate that is not finite, which the error names.
            let wrong = at.iter().position(|coordinate| !coordinate.is_finite());
            let place = row * step + columns[wrong.unwrap_or(0)].offset;
            let weight = weight.map(|column| {
                let (offset, field) = (row * step + column.offset, column);
                let element = self.bytes(offset, field);
                rounded += u64::from(field.scalar.rounds(element, field.endian));
                (Place::Byte(self.start + offset as u64), field.scalar.float(element, field.endian))
            });
            points.push_weighted(Place::Byte(self.start + place as u64), &at, weight)?;
        }
        Ok(rounded)
    }
}
