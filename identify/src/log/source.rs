//! From the bytes of a file to a table: compression, format and encoding.

use super::error::{LogError, ProblemKind, Problems};
use super::limits::{CellCount, Counted, MOST_BYTES, MOST_CELLS};
use super::table::{Demand, Table};
use super::{ends, mcap, parquet, rosbag, text, ulog};
use flate2::read::MultiGzDecoder;
use std::borrow::Cow;
use std::io::{ErrorKind, Read};
use std::path::Path;

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

const GZIP: &[u8] = &[0x1f, 0x8b];

/// First bytes of formats that are easily taken for a log.
const FOREIGN: [(&[u8], &str); 8] = [
    (b"PK\x03\x04", "a ZIP archive or a spreadsheet"),
    (b"\x89HDF", "an HDF5 or MATLAB file"),
    (b"\x28\xb5\x2f\xfd", "a Zstandard archive"),
    (b"BZh", "a bzip2 archive"),
    (b"\x93NUMPY", "a NumPy file"),
    (b"#ROSBAG", "a recording of ROS 1"),
    (b"\xff\xfe", "UTF-16 text"),
    (b"\xfe\xff", "UTF-16 text"),
];

/// First bytes of formats of their own, and who reads them.
const BINARY: [(&[u8], Reader); 4] = [
    (b"PAR1", parquet::table),
    (b"\x89MCAP", mcap::table),
    (rosbag::MAGIC, rosbag::table),
    (b"ULog\x01\x12\x35", ulog::table),
];

type Reader = fn(&[u8], Demand<'_>) -> Result<Table, Problems>;

/// Reads a log of any format that this program knows.
pub(super) fn table(path: &Path, bytes: &[u8], demand: Demand<'_>) -> Result<Table, LogError> {
    let binary = BINARY.iter().find(|(magic, _)| bytes.starts_with(magic));
    let table = match binary {
        Some((_, read)) => read(bytes, demand),
        None => text_table(bytes, demand),
    };
    table.map_err(|found| found.into_error(path))
}

/// Decompresses where needed, removes a byte order mark and garbage at the ends.
fn text_table(bytes: &[u8], demand: Demand<'_>) -> Result<Table, Problems> {
    let bytes = match bytes.starts_with(GZIP) {
        true => Cow::Owned(decompress(bytes).map_err(Problems::whole)?),
        false => {
            measure(bytes).map_err(Problems::whole)?;
            Cow::Borrowed(bytes)
        }
    };
    if let Some((_, what)) = FOREIGN.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Err(Problems::whole(ProblemKind::Foreign(what)));
    }
    let marked = bytes.strip_prefix(BYTE_ORDER_MARK);
    let skipped = bytes.len() - marked.map_or(bytes.len(), <[u8]>::len);
    let sound =
        ends::sound(&bytes[skipped..]).map_err(|offset| not_utf8(&bytes, skipped + offset))?;
    text::parse(sound, demand)
}

/// The place of the first bad byte: its offset and its line, counted from 1.
fn not_utf8(bytes: &[u8], offset: usize) -> Problems {
    let ends = bytes[..offset].iter().filter(|byte| **byte == b'\n');
    let mut problems = Problems::default();
    let line = 1 + ends.count() as u64;
    problems.push(Some(line), None, ProblemKind::NotUtf8 { offset });
    problems
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
