//! What a message consists of: its type as ROS 2 writes it down, with the types of its fields.
//!
//! ```text
//! std_msgs/Header header
//! string[] name
//! float64[9] covariance
//! int32 MOVING=1
//! ================================================================================
//! MSG: std_msgs/Header
//! builtin_interfaces/Time stamp
//! string frame_id
//! ```

use super::known;
use std::collections::{BTreeMap, HashMap};

/// Types within types go this deep at most.
const DEEPEST: usize = 32;

/// Longest text of definitions that is read, in bytes.
const LONGEST: usize = 1 << 20;

/// A number, or what counts as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::log) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    /// By its name in a definition of ROS 2.
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "bool" | "byte" | "char" | "uint8" => Self::U8,
            "int8" => Self::I8,
            "int16" => Self::I16,
            "uint16" => Self::U16,
            "int32" => Self::I32,
            "uint32" => Self::U32,
            "int64" => Self::I64,
            "uint64" => Self::U64,
            "float32" => Self::F32,
            "float64" => Self::F64,
            _ => return None,
        })
    }

    /// How many bytes it takes.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Its value from as many bytes as it takes, of which the most significant may come first; NaN
    /// from fewer.
    pub fn value(self, bytes: &[u8], big: bool) -> f64 {
        let mut ordered = [0; 8];
        let size = self.size();
        let Some(bytes) = bytes.get(..size) else {
            return f64::NAN;
        };
        ordered[..size].copy_from_slice(bytes);
        if big {
            ordered[..size].reverse();
        }
        let all = u64::from_le_bytes(ordered);
        match self {
            Self::I8 => f64::from(all as i8),
            Self::U8 => f64::from(all as u8),
            Self::I16 => f64::from(all as i16),
            Self::U16 => f64::from(all as u16),
            Self::I32 => f64::from(all as i32),
            Self::U32 => f64::from(all as u32),
            Self::I64 => all as i64 as f64,
            Self::U64 => all as f64,
            Self::F32 => f64::from(f32::from_bits(all as u32)),
            Self::F64 => f64::from_bits(all),
        }
    }
}

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Number(Number),
    Text,
    /// A message type, by its place.
    Message(usize),
}

/// How many of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Many {
    One,
    Fixed(usize),
    /// As many as the message says.
    Any,
}

/// A field of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub name: String,
    pub kind: Kind,
    pub many: Many,
}

/// A message type with all that it consists of. It does not contain itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::log) struct Definition {
    /// The types; the first is the message's own.
    messages: Vec<Vec<Field>>,
}

impl Definition {
    pub(super) fn fields(&self, index: usize) -> &[Field] {
        &self.messages[index]
    }

    /// A type from the text that a file has of it.
    ///
    /// # Errors
    /// What cannot be read.
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!(
                "the definition of `{name}` has {} bytes",
                text.len()
            ));
        }
        let name = plain(name);
        let mut texts: HashMap<String, String> = HashMap::new();
        let mut own = name.clone();
        for line in text.lines() {
            if let Some(next) = line.trim().strip_prefix("MSG:") {
                own = plain(next.trim());
            } else if !(line.len() >= 3 && line.bytes().all(|byte| byte == b'=')) {
                let body = texts.entry(own.clone()).or_default();
                body.push_str(line);
                body.push('\n');
            }
        }
        Self::resolved(&name, &texts)
    }

    /// A type that every installation of ROS 2 has, for files that do not define theirs.
    ///
    /// # Errors
    /// If it is not among those that are known.
    pub fn known(name: &str) -> Result<Self, String> {
        Self::resolved(&plain(name), &HashMap::new())
    }

    fn resolved(name: &str, texts: &HashMap<String, String>) -> Result<Self, String> {
        let mut types = Types {
            texts,
            places: BTreeMap::new(),
            messages: Vec::new(),
        };
        types.place(name, DEEPEST)?;
        let messages = types.messages.into_iter().map(Option::unwrap_or_default);
        Ok(Self {
            messages: messages.collect(),
        })
    }
}

/// `sensor_msgs/msg/Imu` is `sensor_msgs/Imu`.
fn plain(name: &str) -> String {
    name.replace("/msg/", "/")
}

struct Types<'a> {
    /// Definitions by name, without those of the types in them.
    texts: &'a HashMap<String, String>,
    places: BTreeMap<String, usize>,
    /// `None` while its fields are being read.
    messages: Vec<Option<Vec<Field>>>,
}

impl Types<'_> {
    fn place(&mut self, name: &str, deeper: usize) -> Result<usize, String> {
        if let Some(&place) = self.places.get(name) {
            return match &self.messages[place] {
                Some(_) => Ok(place),
                None => Err(format!("type `{name}` contains itself")),
            };
        }
        let known = || known::fields(name).map(str::to_owned);
        let text = self.texts.get(name).cloned().or_else(known);
        let text = text.ok_or_else(|| format!("the file does not define type `{name}`"))?;
        let deeper = deeper
            .checked_sub(1)
            .ok_or_else(|| format!("types nest more than {DEEPEST} deep"))?;
        let place = self.messages.len();
        self.places.insert(name.to_owned(), place);
        self.messages.push(None);
        let mut fields = Vec::new();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            fields.extend(self.field(name, line, deeper)?);
        }
        self.messages[place] = Some(fields);
        Ok(place)
    }

    /// `float64[9] covariance`; nothing for a constant, `int32 MOVING=1`.
    fn field(&mut self, own: &str, line: &str, deeper: usize) -> Result<Option<Field>, String> {
        let odd = || format!("`{line}` in type `{own}` is no field");
        let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(odd)?;
        let rest = rest.trim_start();
        let end = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        let (name, after) = rest.split_at(end);
        if after.trim_start().starts_with('=') {
            return Ok(None);
        }
        let (kind, many) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
            None => (kind, Many::One),
            Some((kind, "")) => (kind, Many::Any),
            Some((kind, most)) if most.starts_with("<=") => (kind, Many::Any),
            Some((kind, count)) => {
                let count = count.parse().ok().filter(|count| *count > 0);
                (kind, Many::Fixed(count.ok_or_else(odd)?))
            }
        };
        if name.is_empty() || kind.is_empty() {
            return Err(odd());
        }
        Ok(Some(Field {
            name: name.to_owned(),
            kind: self.kind(own, kind, deeper)?,
            many,
        }))
    }

    fn kind(&mut self, own: &str, name: &str, deeper: usize) -> Result<Kind, String> {
        // A bound, `string<=10`, changes nothing in the encoding.
        let bare = name.split("<=").next().unwrap_or(name);
        if let Some(number) = Number::named(bare) {
            return Ok(Kind::Number(number));
        }
        match bare {
            "string" => return Ok(Kind::Text),
            "wstring" => {
                return Err("it has wide text, which middlewares encode differently".to_owned());
            }
            _ => {}
        }
        let full = plain(bare);
        let full = match full.contains('/') {
            true => full,
            // A neighbour, or the header by its short name.
            false if full == "Header" => "std_msgs/Header".to_owned(),
            false => {
                let package = own.split('/').next().unwrap_or_default();
                format!("{package}/{full}")
            }
        };
        Ok(Kind::Message(self.place(&full, deeper)?))
    }
}
