//! From the bytes of a file to a table: compression, format and encoding.

use super::error::{LogError, Problem, ProblemKind};
use super::limits::{CellCount, Counted, MOST_BYTES, MOST_CELLS};
use super::table::{self, Demand, Table};
use flate2::read::MultiGzDecoder;
use std::borrow::Cow;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::str::Utf8Error;

const BYTE_ORDER_MARK: char = '\u{feff}';

const GZIP: &[u8] = &[0x1f, 0x8b];

/// First bytes of formats that are easily taken for a log.
const FOREIGN: [(&[u8], &str); 6] = [
    (b"PK\x03\x04", "a ZIP archive or a spreadsheet"),
    (b"\x89HDF", "an HDF5 or MATLAB file"),
    (b"\x28\xb5\x2f\xfd", "a Zstandard archive"),
    (b"BZh", "a bzip2 archive"),
    (b"\xff\xfe", "UTF-16 text"),
    (b"\xfe\xff", "UTF-16 text"),
];

/// First bytes of a Parquet file.
const PARQUET: &[u8] = b"PAR1";

/// First bytes of an MCAP file.
const MCAP: &[u8] = b"\x89MCAP";

/// Reads a log of any format that this program knows.
pub(super) fn table(path: &Path, bytes: &[u8], demand: Demand<'_>) -> Result<Table, LogError> {
    if bytes.starts_with(PARQUET) {
        #[cfg(feature = "parquet")]
        return super::parquet::table(bytes, demand).map_err(|found| found.into_error(path));
        #[cfg(not(feature = "parquet"))]
        return Err(LogError::one(path, without("a Parquet file", "parquet")));
    }
    if bytes.starts_with(MCAP) {
        #[cfg(feature = "mcap")]
        return super::mcap::table(bytes, demand).map_err(|found| found.into_error(path));
        #[cfg(not(feature = "mcap"))]
        return Err(LogError::one(path, without("an MCAP file", "mcap")));
    }
    let text = text(bytes).map_err(|problem| LogError::one(path, problem))?;
    table::parse(&text, demand).map_err(|found| found.into_error(path))
}

#[cfg(not(all(feature = "parquet", feature = "mcap")))]
fn without(format: &'static str, feature: &'static str) -> Problem {
    nowhere(ProblemKind::NeedsFeature { format, feature })
}

/// Decompresses where needed, checks the encoding, removes a byte order mark.
fn text(bytes: &[u8]) -> Result<Cow<'_, str>, Problem> {
    let bytes = if bytes.starts_with(GZIP) {
        Cow::Owned(decompress(bytes).map_err(nowhere)?)
    } else {
        measure(bytes).map_err(nowhere)?;
        Cow::Borrowed(bytes)
    };
    if let Some((_, what)) = FOREIGN.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Err(nowhere(ProblemKind::Foreign(what)));
    }
    match bytes {
        Cow::Borrowed(bytes) => std::str::from_utf8(bytes)
            .map(|text| Cow::Borrowed(text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text)))
            .map_err(|error| not_utf8(bytes, error)),
        Cow::Owned(bytes) => match String::from_utf8(bytes) {
            Ok(mut text) => {
                if text.starts_with(BYTE_ORDER_MARK) {
                    text.drain(..BYTE_ORDER_MARK.len_utf8());
                }
                Ok(Cow::Owned(text))
            }
            Err(error) => Err(not_utf8(error.as_bytes(), error.utf8_error())),
        },
    }
}

fn nowhere(kind: ProblemKind) -> Problem {
    Problem {
        line: None,
        column: None,
        kind,
    }
}

/// The place of the first bad byte: its offset and its line, counted from 1.
fn not_utf8(bytes: &[u8], error: Utf8Error) -> Problem {
    let offset = error.valid_up_to();
    let ends = bytes[..offset].iter().filter(|byte| **byte == b'\n');
    Problem {
        line: Some(1 + ends.count() as u64),
        column: None,
        kind: ProblemKind::NotUtf8 { offset },
    }
}

/// Whether a text may be a log by its size.
fn measure(text: &[u8]) -> Result<(), ProblemKind> {
    if text.len() as u64 > MOST_BYTES {
        return Err(ProblemKind::TooLarge { limit: MOST_BYTES });
    }
    let mut count = CellCount::default();
    count.add(text);
    match count.is_exceeded() {
        true => Err(ProblemKind::TooManyCells { limit: MOST_CELLS }),
        false => Ok(()),
    }
}

fn decompress(bytes: &[u8]) -> Result<Vec<u8>, ProblemKind> {
    let mut text = Vec::new();
    let outcome = Counted::new(MultiGzDecoder::new(bytes))
        .take(MOST_BYTES + 1)
        .read_to_end(&mut text);
    let decoded = text.len();
    match outcome {
        Ok(_) if decoded as u64 > MOST_BYTES => Err(ProblemKind::TooLarge { limit: MOST_BYTES }),
        Ok(_) => Ok(text),
        Err(error) => Err(match error.kind() {
            ErrorKind::FileTooLarge => ProblemKind::TooManyCells { limit: MOST_CELLS },
            ErrorKind::UnexpectedEof => ProblemKind::TruncatedGzip { decoded },
            _ => ProblemKind::CorruptGzip {
                decoded,
                reason: error.to_string(),
            },
        }),
    }
}
