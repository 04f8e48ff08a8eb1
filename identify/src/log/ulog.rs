//! Logs of PX4, in its format ULog.
//!
//! Behind sixteen bytes, messages follow each other, each with its length and a letter for its kind.
//! First come formats: names of types with their fields. Subscriptions give a number to a type and to
//! an instance of it; data refers to these. Columns are `topic.field`, of further instances
//! `topic_1.field`. Parameters, texts and dropouts are stepped over.

mod format;

use super::error::{ProblemKind, Problems};
use super::table::{Demand, Table};
use super::topics::Topics;
use super::warning::Warning;
use format::{Formats, Layout};
use std::collections::HashMap;

/// Bytes in front of the messages: a magic, a version, the time of the start.
const HEADER: usize = 16;

/// Flags that say what a reader must know to read on. One is known: data that was appended.
const APPENDED: [u8; 8] = [1, 0, 0, 0, 0, 0, 0, 0];

/// What follows the length and the kind in a message that is there to find the way again.
const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];

/// Kinds of messages that are known; any other is a kind to come, or garbage.
const KINDS: &[u8] = b"BFIMPQARDLCSO";

/// A topic's data: its name and where its numbers stand.
struct Subscription {
    topic: String,
    layout: Result<Layout, String>,
}

/// Reads the topics that are asked for and brings them to the stamps of one.
pub(super) fn table(bytes: &[u8], demand: Demand<'_>) -> Result<Table, Problems> {
    let mut topics = Topics::new(demand);
    let mut formats = Formats::default();
    let mut subscriptions: HashMap<u16, Subscription> = HashMap::new();
    let mut skipped = Skipped::default();
    let mut at = HEADER;
    while at < bytes.len() {
        let found = message(bytes, at);
        let sound = found.filter(|(kind, body)| {
            KINDS.contains(kind) || is_sound_behind(bytes, at + 3 + body.len())
        });
        let Some((kind, body)) = sound else {
            // What a lost card leaves: the next mark says where messages go on.
            match find_sync(bytes, at) {
                Some(next) => {
                    skipped.add(at, next - at);
                    at = next;
                    continue;
                }
                None => {
                    topics.warn(breaks_off(at));
                    break;
                }
            }
        };
        match kind {
            b'B' => check_flags(body)?,
            b'F' => formats.add(body),
            b'A' => subscribe(body, &formats, &mut subscriptions),
            b'D' => data(body, &subscriptions, &mut topics)?,
            _ => {}
        }
        at += 3 + body.len();
    }
    if let Some(warning) = skipped.warning() {
        topics.warn(warning);
    }
    topics.table()
}

fn breaks_off(at: usize) -> Warning {
    Warning::BreaksOff {
        reason: format!("at byte {at} stands no whole message, and no mark behind it"),
    }
}

/// Kind and content of the message at a place; nothing if it does not lie inside of the file.
fn message(bytes: &[u8], at: usize) -> Option<(u8, &[u8])> {
    let (head, rest) = bytes.get(at..)?.split_first_chunk::<3>()?;
    let length = usize::from(u16::from_le_bytes([head[0], head[1]]));
    Some((head[2], rest.get(..length)?))
}

/// Whether a message of a known kind, or the end, stands at a place.
fn is_sound_behind(bytes: &[u8], at: usize) -> bool {
    at == bytes.len() || message(bytes, at).is_some_and(|(kind, _)| KINDS.contains(&kind))
}

/// The end of the next mark that is there to find the way again.
fn find_sync(bytes: &[u8], from: usize) -> Option<usize> {
    let found = bytes[from..].windows(SYNC.len()).position(|w| w == SYNC)?;
    Some(from + found + SYNC.len())
}

/// Eight bytes of flags that any reader may ignore, eight that none may.
fn check_flags(body: &[u8]) -> Result<(), Problems> {
    let needed = body.get(8..16).unwrap_or_default();
    match needed
        .iter()
        .zip(APPENDED)
        .all(|(flags, known)| flags & !known == 0)
    {
        true => Ok(()),
        false => Err(Problems::whole(ProblemKind::Damaged {
            format: "ULog file",
            reason: format!(
                "its flags {needed:02x?} change its format in a way that is not known here"
            ),
        })),
    }
}

/// Instance, number, and the name of the type.
fn subscribe(body: &[u8], formats: &Formats, subscriptions: &mut HashMap<u16, Subscription>) {
    let Some(([instance, low, high], name)) = body.split_first_chunk::<3>() else {
        return;
    };
    let name = String::from_utf8_lossy(name).into_owned();
    let layout = formats.layout(&name);
    let topic = match instance {
        0 => name,
        _ => format!("{name}_{instance}"),
    };
    let number = u16::from_le_bytes([*low, *high]);
    subscriptions.insert(number, Subscription { topic, layout });
}

/// The number of a subscription, and a message of its type.
fn data(
    body: &[u8],
    subscriptions: &HashMap<u16, Subscription>,
    topics: &mut Topics<'_>,
) -> Result<(), Problems> {
    let Some((number, body)) = body.split_first_chunk::<2>() else {
        return Ok(());
    };
    let number = u16::from_le_bytes(*number);
    let Some(Subscription { topic, layout }) = subscriptions.get(&number) else {
        topics.ignore(&format!("number {number}"), "no subscription names it");
        return Ok(());
    };
    match layout {
        Err(reason) => topics.ignore(topic, reason.as_str()),
        // A message that the card cut short is no reason to leave out the others.
        Ok(layout) if body.len() < layout.needed() => {}
        Ok(layout) => {
            let microseconds = layout.timestamp(body);
            topics.message(topic, 1000 * microseconds, |open| {
                layout.read(body, open);
                Ok(())
            })?;
        }
    }
    Ok(())
}

/// Stretches of the file in which no message stands.
#[derive(Default)]
struct Skipped {
    first: Option<usize>,
    bytes: usize,
}

impl Skipped {
    fn add(&mut self, at: usize, bytes: usize) {
        self.first.get_or_insert(at);
        self.bytes += bytes;
    }

    fn warning(&self) -> Option<Warning> {
        self.first.map(|at| Warning::SkippedBytes {
            at,
            bytes: self.bytes,
        })
    }
}
