//! Logs in the SQLite files (`.db3`) of ROS 2's recorder: messages in CDR. Recordings since the
//! release Iron define the types of their messages; for those before, the types that every
//! installation has are known.

use super::cdr::Definition;
use super::error::{ProblemKind, Problems};
use super::limits::MOST_MESSAGE_BYTES;
use super::table::{Demand, Table};
use super::topics::Topics;
use super::warning::Warning;
use rusqlite::{Connection, Error, MAIN_DB, Row};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Where the header of a file says how it was written and how it is to be read: 2 for a journal
/// beside it, which a file in memory cannot have.
const JOURNAL: std::ops::Range<usize> = 18..20;

/// First bytes of the files.
pub(super) const MAGIC: &[u8] = b"SQLite format 3\0";

/// What a recorder that was stopped left in the journal beside a file, which is not read.
pub(super) fn left_behind(path: &Path, bytes: &[u8]) -> Option<Warning> {
    let mut journal = path.as_os_str().to_owned();
    journal.push("-wal");
    let journal = PathBuf::from(journal);
    let found = bytes.starts_with(MAGIC) && journal.metadata().is_ok_and(|file| file.len() > 0);
    found.then(|| Warning::BreaksOff {
        reason: format!(
            "its last messages stand in `{}` (`sqlite3 {} .tables` moves them over)",
            journal.display(),
            path.display()
        ),
    })
}

/// Reads the topics that are asked for and brings them to the stamps of one.
pub(super) fn table(bytes: &[u8], demand: Demand<'_>) -> Result<Table, Problems> {
    let database = open(bytes).map_err(damaged)?;
    let mut topics = Topics::new(demand);
    let known = recorded(&database).map_err(damaged)?;
    let mut size = 0;
    // In the order in which they were written: no index needs to be sound.
    let select = "SELECT topic_id, timestamp, data FROM messages NOT INDEXED ORDER BY rowid";
    let mut statement = database.prepare(select).map_err(damaged)?;
    let mut rows = statement.query([]).map_err(damaged)?;
    while let Some(row) = rows.next().map_err(damaged)? {
        let (number, logged, data) = message(row).map_err(damaged)?;
        size += data.len() as u64;
        if size > MOST_MESSAGE_BYTES {
            let limit = MOST_MESSAGE_BYTES;
            return Err(Problems::whole(ProblemKind::TooLarge { limit }));
        }
        let Some(Recorded { name, definition }) = known.get(&number) else {
            topics.ignore(&format!("number {number}"), "the file does not name it");
            continue;
        };
        match definition {
            Ok(definition) => {
                topics.message(name, i128::from(logged), |open| definition.read(data, open))?
            }
            Err(reason) => topics.ignore(name, reason.as_str()),
        }
    }
    topics.table()
}

fn damaged(error: Error) -> Problems {
    Problems::whole(ProblemKind::Damaged {
        format: "recording of ROS 2 in SQLite",
        reason: error.to_string(),
    })
}

/// The file as a database in memory, where nobody can write to it.
fn open(bytes: &[u8]) -> Result<Connection, Error> {
    let mut bytes = bytes.to_vec();
    if let Some(journal) = bytes.get_mut(JOURNAL) {
        journal.fill(1);
    }
    let mut database = Connection::open_in_memory()?;
    database.deserialize_read_exact(MAIN_DB, bytes.as_slice(), bytes.len(), true)?;
    Ok(database)
}

/// A topic of the recording.
struct Recorded {
    name: String,
    definition: Result<Definition, String>,
}

/// The topics by their numbers.
fn recorded(database: &Connection) -> Result<HashMap<i64, Recorded>, Error> {
    let definitions = definitions(database)?;
    let mut statement =
        database.prepare("SELECT id, name, type, serialization_format FROM topics")?;
    let topics = statement.query_map([], |row| {
        let (number, name): (i64, String) = (row.get(0)?, row.get(1)?);
        let (kind, encoding): (String, String) = (row.get(2)?, row.get(3)?);
        let definition = match (encoding.as_str(), definitions.get(&kind)) {
            ("cdr", Some(text)) => Definition::parse(&kind, text),
            ("cdr", None) => Definition::known(&kind),
            (other, _) => Err(format!("its messages are `{other}`, not `cdr`")),
        };
        Ok((number, Recorded { name, definition }))
    });
    topics?.collect()
}

/// The definitions of types, by their names, that the file has.
fn definitions(database: &Connection) -> Result<HashMap<String, String>, Error> {
    let table =
        "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = 'message_definitions'";
    let tables: i64 = database.query_row(table, [], |row| row.get(0))?;
    if tables == 0 {
        return Ok(HashMap::new());
    }
    let select = "SELECT topic_type, encoded_message_definition FROM message_definitions WHERE encoding = 'ros2msg'";
    let mut statement = database.prepare(select)?;
    let definitions = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)));
    definitions?.collect()
}

/// Topic, time of logging \[ns\] and content of a message.
fn message<'a>(row: &'a Row<'_>) -> Result<(i64, i64, &'a [u8]), Error> {
    let data = row.get_ref(2)?.as_blob();
    let data = data.map_err(|error| {
        Error::FromSqlConversionFailure(2, rusqlite::types::Type::Blob, error.into())
    })?;
    Ok((row.get(0)?, row.get(1)?, data))
}
