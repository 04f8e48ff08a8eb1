//! Logs in MCAP files: messages in JSON, or in CDR with the definitions of their types.

use super::cdr::Definition;
use super::error::{ProblemKind, Problems};
use super::json;
use super::limits::MOST_MESSAGE_BYTES;
use super::table::{Demand, Table};
use super::topics::Topics;
use super::warning::Warning;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use mcap::{McapError, Message};
use std::collections::HashMap;
use std::panic::catch_unwind;

/// Records and chunks longer than this many bytes are refused.
const LARGEST_RECORD: usize = 1 << 28;

/// Reads the topics that are asked for and brings them to the stamps of one.
pub(super) fn table(bytes: &[u8], demand: Demand<'_>) -> Result<Table, Problems> {
    // The reader takes lengths of records inside chunks at their word, and subtracts them.
    let outcome = catch_unwind(|| topics(bytes, demand));
    outcome.unwrap_or_else(|_| Err(damaged("its records contradict one another".to_owned())))
}

fn topics(bytes: &[u8], demand: Demand<'_>) -> Result<Table, Problems> {
    let mut topics = Topics::new(demand);
    let mut types = Types::default();
    let mut size = 0;
    let mut last = None;
    // Checked first: a damaged chunk may say that it has more than memory holds.
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(LARGEST_RECORD);
    for message in MessageReader::new_with_options(bytes, options) {
        let message = match message {
            Ok(message) => message,
            // Whoever recorded it was stopped: what is there is sound.
            Err(McapError::UnexpectedEof | McapError::UnexpectedEoc) if last.is_some() => {
                let reason = "it has no end, as if its recorder had been stopped".to_owned();
                topics.warn(Warning::BreaksOff { reason });
                break;
            }
            Err(McapError::ChunkTooLarge(_) | McapError::RecordTooLarge { .. }) => {
                let limit = LARGEST_RECORD as u64;
                return Err(Problems::whole(ProblemKind::PieceTooLarge { limit }));
            }
            Err(error) => return Err(damaged(error.to_string())),
        };
        size += message.data.len() as u64;
        if size > MOST_MESSAGE_BYTES {
            let limit = MOST_MESSAGE_BYTES;
            return Err(Problems::whole(ProblemKind::TooLarge { limit }));
        }
        last = Some(message.log_time);
        let (topic, logged) = (&message.channel.topic, i128::from(message.log_time));
        match message.channel.message_encoding.as_str() {
            "json" => topics.message(topic, logged, |open| json::read(&message.data, open))?,
            "cdr" => match types.of(&message) {
                Ok(definition) => {
                    topics.message(topic, logged, |open| definition.read(&message.data, open))?
                }
                Err(reason) => topics.ignore(topic, reason.as_str()),
            },
            other => topics.ignore(
                topic,
                format!("its messages are `{other}`, neither `cdr` nor `json`"),
            ),
        }
    }
    topics.table()
}

fn damaged(reason: String) -> Problems {
    Problems::whole(ProblemKind::Damaged {
        format: "MCAP file",
        reason,
    })
}

/// The types of messages in CDR, by the number of their schema.
#[derive(Default)]
struct Types(HashMap<u16, Result<Definition, String>>);

impl Types {
    fn of(&mut self, message: &Message<'_>) -> &Result<Definition, String> {
        let schema = message.channel.schema.as_ref();
        let number = schema.map_or(0, |schema| schema.id);
        self.0.entry(number).or_insert_with(|| {
            let schema = schema.ok_or_else(|| "the file does not define its type".to_owned())?;
            match schema.encoding.as_str() {
                "ros2msg" => {
                    let text = String::from_utf8_lossy(&schema.data);
                    Definition::parse(&schema.name, &text)
                }
                other => Definition::known(&schema.name)
                    .map_err(|_| format!("its type is defined in `{other}`, not in `ros2msg`")),
            }
        })
    }
}
