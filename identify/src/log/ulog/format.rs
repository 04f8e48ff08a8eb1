//! Types of ULog: `name:float[4] q;uint64_t timestamp;uint8_t[4] _padding0`, of which the last
//! padding is not written.

use crate::log::cdr::Number;
use crate::log::topics::{LONGEST_LIST, Topic};
use std::collections::HashMap;

/// Types within types go this deep at most.
const DEEPEST: usize = 16;

/// Most numbers of a message. The length of one has sixteen bits.
const MOST_NUMBERS: usize = 1 << 16;

/// What padding between fields is called.
const PADDING: &str = "_padding";

/// The types that a file defines.
#[derive(Debug, Default)]
pub(super) struct Formats(HashMap<String, Vec<Field>>);

#[derive(Debug, Clone)]
struct Field {
    kind: String,
    /// How many of it, if it is a list.
    count: Option<usize>,
    name: String,
}

/// Where the numbers of a type stand in its messages.
#[derive(Debug)]
pub(super) struct Layout {
    /// Path, kind and offset of each.
    numbers: Vec<(String, Number, usize)>,
    /// Where the stamp stands.
    timestamp: usize,
    /// Bytes that a message has at least.
    needed: usize,
}

impl Formats {
    /// Takes in a type; one that cannot be read is missed when it is wanted.
    pub fn add(&mut self, text: &[u8]) {
        let text = String::from_utf8_lossy(text);
        if let Some((name, fields)) = text.split_once(':') {
            let fields = fields
                .split(';')
                .map(str::trim)
                .filter(|field| !field.is_empty());
            if let Some(fields) = fields.map(Field::parse).collect() {
                self.0.insert(name.trim().to_owned(), fields);
            }
        }
    }

    /// Where the numbers of a type stand.
    ///
    /// # Errors
    /// If it, or a type in it, is not defined, or it has no stamp.
    pub fn layout(&self, name: &str) -> Result<Layout, String> {
        let mut layout = Layout {
            numbers: Vec::new(),
            timestamp: 0,
            needed: 0,
        };
        let mut offset = 0;
        self.lay(name, "", DEEPEST, &mut offset, &mut layout)?;
        let stamp = layout
            .numbers
            .iter()
            .position(|(path, kind, _)| path == "timestamp" && *kind == Number::U64);
        let stamp = stamp.ok_or_else(|| format!("its type `{name}` has no `timestamp`"))?;
        layout.timestamp = layout.numbers.remove(stamp).2;
        let ends = layout.numbers.iter().map(|(_, kind, at)| at + kind.size());
        layout.needed = ends
            .max()
            .unwrap_or(0)
            .max(layout.timestamp + Number::U64.size());
        Ok(layout)
    }

    fn lay(
        &self,
        name: &str,
        path: &str,
        deeper: usize,
        offset: &mut usize,
        layout: &mut Layout,
    ) -> Result<(), String> {
        let fields = self.0.get(name);
        let fields = fields.ok_or_else(|| format!("the file does not define its type `{name}`"))?;
        let deeper = deeper
            .checked_sub(1)
            .ok_or_else(|| format!("types in its type nest more than {DEEPEST} deep"))?;
        for Field { kind, count, name } in fields {
            let is_kept = !name.starts_with(PADDING) && count.is_none_or(|n| n <= LONGEST_LIST);
            for index in 0..count.unwrap_or(1) {
                let dot = if path.is_empty() { "" } else { "." };
                let path = match count {
                    None => format!("{path}{dot}{name}"),
                    Some(_) => format!("{path}{dot}{name}.{index}"),
                };
                match number(kind) {
                    Some(number) => {
                        if is_kept && kind != "char" {
                            layout.numbers.push((path, number, *offset));
                        }
                        *offset += number.size();
                    }
                    None => self.lay(kind, &path, deeper, offset, layout)?,
                }
                if *offset > MOST_NUMBERS {
                    return Err(format!("its type has more than {MOST_NUMBERS} bytes"));
                }
            }
        }
        Ok(())
    }
}

impl Field {
    /// `float[4] q`
    fn parse(text: &str) -> Option<Self> {
        let (kind, name) = text.split_once(' ')?;
        let (kind, count) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
            None => (kind, None),
            Some((kind, count)) => (kind, Some(count.parse().ok()?)),
        };
        Some(Self {
            kind: kind.to_owned(),
            count,
            name: name.trim().to_owned(),
        })
    }
}

/// A number by its name in C.
fn number(kind: &str) -> Option<Number> {
    Some(match kind {
        "int8_t" => Number::I8,
        "uint8_t" | "bool" | "char" => Number::U8,
        "int16_t" => Number::I16,
        "uint16_t" => Number::U16,
        "int32_t" => Number::I32,
        "uint32_t" => Number::U32,
        "int64_t" => Number::I64,
        "uint64_t" => Number::U64,
        "float" => Number::F32,
        "double" => Number::F64,
        _ => return None,
    })
}

impl Layout {
    /// Bytes that a message has at least.
    pub fn needed(&self) -> usize {
        self.needed
    }

    /// When a message was written, in microseconds.
    pub fn timestamp(&self, body: &[u8]) -> i128 {
        let bytes = body
            .get(self.timestamp..)
            .and_then(|rest| rest.first_chunk::<8>());
        bytes.map_or(0, |bytes| i128::from(u64::from_le_bytes(*bytes)))
    }

    /// Takes in a message.
    pub fn read(&self, body: &[u8], message: &mut Topic) {
        for (path, kind, at) in &self.numbers {
            let before = message.enter(path);
            message.number(kind.value(body.get(*at..).unwrap_or_default(), false));
            message.leave(before);
        }
    }
}
