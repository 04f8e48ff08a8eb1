//! Logs in Parquet files: one row per sample, numbers in columns of their own.

use super::error::{ProblemKind, Problems};
use super::limits::{MOST_BYTES, check};
use super::table::{Cell, Demand, Table, from_columns, shortened};
use bytes::Bytes;
use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use parquet::schema::types::{Type, TypePtr};
use std::panic::catch_unwind;

/// Reads all columns that are not nested. Stamps since 1970 become seconds.
pub(super) fn table(bytes: &[u8], demand: Demand<'_>) -> Result<Table, Problems> {
    // The reader takes lengths and offsets inside pages at their word.
    let outcome = catch_unwind(|| columns(bytes));
    let outcome = outcome.unwrap_or_else(|_| Err(damaged("its pages contradict one another")));
    let columns = outcome.map_err(|kind| {
        let mut problems = Problems::default();
        problems.push(None, None, kind);
        problems
    })?;
    from_columns(columns, demand)
}

fn damaged(reason: impl Into<String>) -> ProblemKind {
    ProblemKind::Damaged {
        format: "Parquet file",
        reason: reason.into(),
    }
}

fn columns(bytes: &[u8]) -> Result<Vec<(String, Vec<Cell>)>, ProblemKind> {
    let said = |error: ParquetError| damaged(error.to_string());
    let reader = SerializedFileReader::new(Bytes::copy_from_slice(bytes)).map_err(said)?;
    if let Some(reason) = misplaced(reader.metadata(), bytes.len()) {
        return Err(damaged(reason));
    }
    check_size(reader.metadata())?;
    let schema = reader.metadata().file_metadata().schema();
    let fields = schema.get_fields().iter().cloned();
    // Text stands in a dictionary once, and for every row that has it: it is not unpacked.
    let (numbers, others): (Vec<TypePtr>, Vec<TypePtr>) = fields.partition(is_number);
    let named = |field: &TypePtr| field.name().to_owned();
    let mut columns: Vec<(String, Vec<Cell>)> = numbers
        .iter()
        .map(|field| (named(field), Vec::new()))
        .collect();
    if !numbers.is_empty() {
        let projection = Type::group_type_builder(schema.name()).with_fields(numbers);
        let projection = projection.build().map_err(said)?;
        for row in reader.get_row_iter(Some(projection)).map_err(said)? {
            let row = row.map_err(said)?;
            for ((_, cells), (_, field)) in columns.iter_mut().zip(row.get_column_iter()) {
                cells.push(cell(field));
            }
        }
    }
    let unread = || vec![Cell::Other("text, a list or a structure".into())];
    columns.extend(others.iter().map(|field| (named(field), unread())));
    Ok(columns)
}

/// Whether a field is a column of numbers.
fn is_number(field: &TypePtr) -> bool {
    let repeats = field.get_basic_info().has_repetition()
        && field.get_basic_info().repetition() == Repetition::REPEATED;
    let is_text = || match field.get_physical_type() {
        PhysicalType::BYTE_ARRAY | PhysicalType::INT96 => true,
        PhysicalType::FIXED_LEN_BYTE_ARRAY => {
            field.get_basic_info().logical_type_ref() != Some(&LogicalType::Float16)
        }
        _ => false,
    };
    field.is_primitive() && !repeats && !is_text()
}

/// Whether the file holds no more than is read, by what it says itself.
fn check_size(metadata: &ParquetMetaData) -> Result<(), ProblemKind> {
    let file = metadata.file_metadata();
    let rows = usize::try_from(file.num_rows())
        .map_err(|_| damaged(format!("it has {} rows", file.num_rows())))?;
    check(rows, file.schema().get_fields().len())?;
    let groups = metadata.row_groups().iter();
    let columns = groups.flat_map(|group| group.columns());
    let sizes = columns.map(|column| u64::try_from(column.uncompressed_size()).unwrap_or(u64::MAX));
    match sizes.fold(0_u64, u64::saturating_add) <= MOST_BYTES {
        true => Ok(()),
        false => Err(ProblemKind::TooLarge { limit: MOST_BYTES }),
    }
}

/// Whether a column lies outside of the file: the reader would not survive it.
fn misplaced(metadata: &ParquetMetaData, size: usize) -> Option<String> {
    let mut columns = metadata
        .row_groups()
        .iter()
        .flat_map(|group| group.columns());
    let outside = columns.find(|column| {
        let pages = column
            .dictionary_page_offset()
            .unwrap_or(column.data_page_offset());
        let end = pages.checked_add(column.compressed_size());
        let sound = pages >= 0 && column.data_page_offset() >= 0 && column.compressed_size() >= 0;
        !sound
            || end
                .and_then(|end| usize::try_from(end).ok())
                .is_none_or(|end| end > size)
    })?;
    let path = outside.column_path();
    Some(format!("column {path} does not lie inside of the file"))
}

fn cell(field: &Field) -> Cell {
    Cell::Number(match field {
        Field::Null => return Cell::Empty,
        Field::Bool(value) => f64::from(u8::from(*value)),
        Field::Byte(value) => f64::from(*value),
        Field::Short(value) => f64::from(*value),
        Field::Int(value) => f64::from(*value),
        Field::Long(value) => *value as f64,
        Field::UByte(value) => f64::from(*value),
        Field::UShort(value) => f64::from(*value),
        Field::UInt(value) => f64::from(*value),
        Field::ULong(value) => *value as f64,
        Field::Float16(value) => f64::from(*value),
        Field::Float(value) => f64::from(*value),
        Field::Double(value) => *value,
        Field::TimestampMillis(value) => *value as f64 * 1e-3,
        Field::TimestampMicros(value) => *value as f64 * 1e-6,
        other => return Cell::Other(shortened(&other.to_string()).into()),
    })
}
