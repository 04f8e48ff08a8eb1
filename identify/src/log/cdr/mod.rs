//! Messages in CDR, the encoding of DDS and of ROS 2, read by the definitions of their types.
//!
//! Numbers stand at multiples of their own size, counted from behind the four bytes that say which
//! end of a number comes first.

mod definition;
mod known;

pub(super) use definition::{Definition, Number};

use super::topics::{LONGEST_LIST, Topic};
use definition::{Field, Kind, Many};

/// Bytes in front of a message.
const HEAD: usize = 4;

impl Definition {
    /// Takes in a message of this type.
    ///
    /// # Errors
    /// If it breaks off, or is encoded in another way.
    pub fn read(&self, bytes: &[u8], message: &mut Topic) -> Result<(), String> {
        let Some((head, body)) = bytes.split_at_checked(HEAD) else {
            return Err(cut(0));
        };
        // Plain CDR of either version; what names its members, or says how long they are, is read
        // by nobody who records.
        let (big, widest) = match [head[0], head[1]] {
            [0, 0] => (true, 8),
            [0, 1] => (false, 8),
            [0, 6] => (true, 4),
            [0, 7] => (false, 4),
            [a, b] => {
                return Err(format!(
                    "a message of it is in an encoding ({a:02x} {b:02x}) that is no plain CDR"
                ));
            }
        };
        let mut reader = Reader {
            body,
            at: 0,
            big,
            widest,
            message,
            muted: false,
        };
        reader.message(self, 0)
    }
}

fn cut(at: usize) -> String {
    format!("a message of it ends at byte {at}, before its type does")
}

struct Reader<'a> {
    body: &'a [u8],
    at: usize,
    /// Whether the most significant byte comes first.
    big: bool,
    /// No number is aligned to more bytes than this.
    widest: usize,
    message: &'a mut Topic,
    /// Whether what is read is too long a list to be joints.
    muted: bool,
}

impl<'a> Reader<'a> {
    /// All fields of message type `index`.
    fn message(&mut self, definition: &Definition, index: usize) -> Result<(), String> {
        let fields = definition.fields(index);
        // A type without fields is written as one byte.
        if fields.is_empty() {
            return self.take(1).map(drop);
        }
        for field in fields {
            let before = self.message.enter(&field.name);
            self.field(definition, field)?;
            self.message.leave(before);
        }
        Ok(())
    }

    fn field(&mut self, definition: &Definition, field: &Field) -> Result<(), String> {
        let count = match field.many {
            Many::One => return self.value(definition, field.kind),
            Many::Fixed(count) => count,
            Many::Any => self.number(Number::U32)? as usize,
        };
        if let Kind::Number(number) = field.kind
            && count > LONGEST_LIST
        {
            self.align(number.size());
            return self.take(count.saturating_mul(number.size())).map(drop);
        }
        let was_muted = self.muted;
        self.muted |= count > LONGEST_LIST;
        for index in 0..count {
            if self.muted {
                self.value(definition, field.kind)?;
                continue;
            }
            let before = self.message.enter(&index.to_string());
            self.value(definition, field.kind)?;
            self.message.leave(before);
        }
        self.muted = was_muted;
        Ok(())
    }

    fn value(&mut self, definition: &Definition, kind: Kind) -> Result<(), String> {
        match kind {
            Kind::Number(number) => {
                let value = self.number(number)?;
                if !self.muted {
                    self.message.number(value);
                }
                Ok(())
            }
            Kind::Text => {
                let length = self.number(Number::U32)? as usize;
                let bytes = self.take(length)?;
                if !self.muted {
                    let text = bytes.strip_suffix(b"\0").unwrap_or(bytes);
                    self.message.text(&String::from_utf8_lossy(text));
                }
                Ok(())
            }
            Kind::Message(index) => self.message(definition, index),
        }
    }

    fn number(&mut self, number: Number) -> Result<f64, String> {
        self.align(number.size());
        let big = self.big;
        Ok(number.value(self.take(number.size())?, big))
    }

    fn align(&mut self, size: usize) {
        self.at = self.at.next_multiple_of(size.min(self.widest));
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self
            .at
            .checked_add(count)
            .filter(|end| *end <= self.body.len());
        let end = end.ok_or_else(|| cut(HEAD + self.body.len()))?;
        let taken = &self.body[self.at..end];
        self.at = end;
        Ok(taken)
    }
}

#[cfg(test)]
mod tests;
