//! Logs in Parquet files: one row per sample, numbers in columns of their own.

use super::error::{ProblemKind, Problems};
use super::table::{Cell, Demand, Table, from_columns};
use bytes::Bytes;
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::panic::catch_unwind;

/// Most cells that are read; a small file may say that it has more than memory holds.
const MOST_CELLS: usize = 1 << 27;

/// Reads all columns that are not nested. Stamps since 1970 become seconds.
pub(super) fn table(bytes: &[u8], demand: Demand<'_>) -> Result<Table, Problems> {
    // The reader takes lengths and offsets inside pages at their word.
    let outcome = catch_unwind(|| columns(bytes));
    let outcome = outcome.unwrap_or_else(|_| Err("its pages contradict one another".to_owned()));
    let columns = outcome.map_err(|reason| {
        let mut problems = Problems::default();
        let format = "Parquet file";
        problems.push(None, None, ProblemKind::Damaged { format, reason });
        problems
    })?;
    from_columns(columns, demand)
}

fn columns(bytes: &[u8]) -> Result<Vec<(String, Vec<Cell>)>, String> {
    let said = |error: ParquetError| error.to_string();
    let reader = SerializedFileReader::new(Bytes::copy_from_slice(bytes)).map_err(said)?;
    if let Some(reason) = misplaced(reader.metadata(), bytes.len()) {
        return Err(reason);
    }
    let schema = reader.metadata().file_metadata().schema();
    let names = schema
        .get_fields()
        .iter()
        .map(|field| field.name().to_owned());
    let mut columns: Vec<(String, Vec<Cell>)> = names.map(|name| (name, Vec::new())).collect();
    let rows = reader.metadata().file_metadata().num_rows();
    let cells = usize::try_from(rows)
        .ok()
        .and_then(|rows| rows.checked_mul(columns.len()));
    if cells.is_none_or(|cells| cells > MOST_CELLS) {
        return Err(format!(
            "{rows} rows of {} columns are more than can be read",
            columns.len()
        ));
    }
    for row in reader.get_row_iter(None).map_err(said)? {
        let row = row.map_err(said)?;
        for ((_, cells), (_, field)) in columns.iter_mut().zip(row.get_column_iter()) {
            cells.push(cell(field));
        }
    }
    Ok(columns)
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
        other => return Cell::Other(other.to_string()),
    })
}
