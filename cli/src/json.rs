//! JSON whose values know where they stand, so that a fault in a value can be
//! pointed at as well as a fault in the syntax.

use crate::mistake::{Mistake, Place};
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;
use std::collections::HashSet;
use std::fmt;
use std::ops::Range;

/// A piece of a file: one line, or the whole.
#[derive(Debug, Clone, Copy)]
pub struct Text<'a> {
    /// What the user calls the file.
    pub file: &'a str,
    /// The number of the first line of `text`, from one.
    pub first_line: usize,
    /// The characters.
    pub text: &'a str,
    /// What the text should be, for whoever wrote something else.
    pub shape: &'static str,
}

/// A JSON value at its place.
#[derive(Debug, Clone, Copy)]
pub struct Value<'a> {
    within: Text<'a>,
    raw: &'a str,
}

/// A member of an object.
#[derive(Debug, Clone)]
pub struct Member<'a> {
    /// The name, unescaped.
    pub name: String,
    /// The name as it stands in the text.
    pub key: Value<'a>,
    /// What it is set to.
    pub value: Value<'a>,
}

impl<'a> Text<'a> {
    /// The value that the text consists of.
    ///
    /// # Errors
    /// If it is not JSON.
    pub fn value(self) -> Result<Value<'a>, Mistake> {
        match serde_json::from_str::<&RawValue>(self.text) {
            Ok(raw) => Ok(self.locate(raw)),
            Err(error) => Err(self.syntax(&error)),
        }
    }

    /// A mistake at a range of the text.
    pub fn mistake(self, range: Range<usize>, label: &str, message: impl Into<String>) -> Mistake {
        let place = Place {
            file: self.file.to_string(),
            first_line: self.first_line,
            text: self.text.to_string(),
            range,
            label: label.to_string(),
        };
        Mistake::at(place, message)
    }

    fn locate(self, raw: &'a RawValue) -> Value<'a> {
        Value {
            within: self,
            raw: raw.get(),
        }
    }

    fn syntax(self, error: &serde_json::Error) -> Mistake {
        let mut start = self.offset(error.line(), error.column());
        if self.text[..start].ends_with('-') {
            start -= 1;
        }
        let rest = &self.text[start..];
        let word: String = rest
            .chars()
            .take_while(|c| c.is_alphanumeric() || matches!(c, '-' | '+' | '.' | '_'))
            .collect();
        let end = start
            + word
                .len()
                .max(rest.chars().next().map_or(0, char::len_utf8));
        let bare = word.trim_start_matches(['-', '+']).to_lowercase();
        if matches!(bare.as_str(), "nan" | "inf" | "infinity") {
            let message = format!("`{word}` is not a JSON value");
            return self
                .mistake(start..end, "", message)
                .help("only finite numbers make sense here");
        }
        let what = reason(error);
        let message = match what.strip_prefix("EOF while parsing ") {
            Some(open) => format!("this is not JSON: it ends in the middle of {open}"),
            None => format!("this is not JSON: {what}"),
        };
        self.mistake(start..end, "", message).help(self.shape)
    }

    /// The byte behind which `serde_json` stopped: it counts lines from one, and
    /// columns by the bytes it has read.
    fn offset(self, line: usize, column: usize) -> usize {
        let before: usize = self
            .text
            .split_inclusive('\n')
            .take(line.saturating_sub(1))
            .map(str::len)
            .sum();
        let mut at = (before + column.saturating_sub(1)).min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        at
    }
}

/// The error without the place, which is ours to give.
fn reason(error: &serde_json::Error) -> String {
    let what = error.to_string();
    what.split(" at line ").next().unwrap_or(&what).to_string()
}

/// A JSON object with its members in order, repeated names included.
struct Members<'a>(Vec<(&'a RawValue, &'a RawValue)>);

impl<'de> Deserialize<'de> for Members<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Collect;
        impl<'de> Visitor<'de> for Collect {
            type Value = Members<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Members<'de>, A::Error> {
                let mut members = Vec::new();
                while let Some(member) = map.next_entry()? {
                    members.push(member);
                }
                Ok(Members(members))
            }
        }
        deserializer.deserialize_map(Collect)
    }
}

impl<'a> Value<'a> {
    /// A mistake that underlines this value.
    pub fn mistake(&self, label: &str, message: impl Into<String>) -> Mistake {
        // `raw` is a slice of `within.text`, so the difference is its offset.
        let start = self.raw.as_ptr() as usize - self.within.text.as_ptr() as usize;
        self.within
            .mistake(start..start + self.raw.len(), label, message)
    }

    /// Whether it is an object.
    pub fn is_object(&self) -> bool {
        self.raw.starts_with('{')
    }

    /// Its members, each name once. `what` says in a message what was expected.
    ///
    /// # Errors
    /// If it is not an object, or a name stands in it twice.
    pub fn members(&self, what: &str) -> Result<Vec<Member<'a>>, Mistake> {
        if !self.is_object() {
            return Err(self
                .mistake(self.kind(), format!("expected {what}"))
                .help(self.within.shape));
        }
        let Members(pairs) = serde_json::from_str(self.raw).map_err(|e| self.odd(&e))?;
        let mut members: Vec<Member<'a>> = Vec::with_capacity(pairs.len());
        let mut names = HashSet::with_capacity(pairs.len());
        for (key, value) in pairs {
            let name: String = serde_json::from_str(key.get()).map_err(|e| self.odd(&e))?;
            let key = self.within.locate(key);
            if !names.insert(name.clone()) {
                let mistake = key.mistake("again here", format!("`{name}` is given twice"));
                return Err(mistake.help("keep one of them"));
            }
            let value = self.within.locate(value);
            members.push(Member { name, key, value });
        }
        Ok(members)
    }

    /// Its elements. `what` says in a message what was expected.
    ///
    /// # Errors
    /// If it is not an array.
    pub fn elements(&self, what: &str) -> Result<Vec<Value<'a>>, Mistake> {
        if !self.raw.starts_with('[') {
            return Err(self
                .mistake(self.kind(), format!("expected {what}"))
                .help(self.within.shape));
        }
        let values: Vec<&'a RawValue> = serde_json::from_str(self.raw).map_err(|e| self.odd(&e))?;
        Ok(values
            .into_iter()
            .map(|raw| self.within.locate(raw))
            .collect())
    }

    /// Its number. `what` says in a message what it is the value of.
    ///
    /// # Errors
    /// If it is not a finite number.
    pub fn number(&self, what: &str) -> Result<f64, Mistake> {
        let numeric = self
            .raw
            .starts_with(|c: char| c == '-' || c.is_ascii_digit());
        if !numeric {
            let mistake = self.mistake(self.kind(), format!("{what} must be a number"));
            return Err(match self.raw.starts_with('"') {
                true => mistake.help("numbers stand without quotes"),
                false => mistake.help("give a number, such as `0.5` or `-1e-3`"),
            });
        }
        match serde_json::from_str::<f64>(self.raw) {
            Ok(value) if value.is_finite() => Ok(value),
            _ => {
                let message = format!("{what} must be a finite number");
                Err(self
                    .mistake("too large", message)
                    .help("check its exponent"))
            }
        }
    }

    fn kind(&self) -> &'static str {
        match self.raw.chars().next() {
            Some('{') => "this is an object",
            Some('[') => "this is an array",
            Some('"') => "this is text",
            Some('t' | 'f') => "this is a truth value",
            Some('n') => "this is `null`",
            _ => "this is a number",
        }
    }

    /// Faults inside a value whose syntax has been checked: half a surrogate pair.
    fn odd(&self, error: &serde_json::Error) -> Mistake {
        self.mistake("", format!("this cannot be read: {}", reason(error)))
            .help(self.within.shape)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> Text<'_> {
        Text {
            file: "f.json",
            first_line: 1,
            text,
            shape: "an object",
        }
    }

    #[test]
    fn values_know_their_place() {
        let object = text(r#"{"q": [1, "x"]}"#).value().unwrap();
        let q = &object.members("an object").unwrap()[0];
        let elements = q.value.elements("an array").unwrap();
        assert_eq!(elements[0].number("q").unwrap(), 1.0);
        let shown = elements[1].number("`q`").unwrap_err().to_string();
        assert!(shown.contains("f.json:1:11"), "{shown}");
    }

    /// An object may be as long as a line.
    #[test]
    fn many_members_are_read_in_order() {
        let members = (0..200_000).map(|i| format!("\"m{i}\": {i}"));
        let object = format!("{{{}}}", members.collect::<Vec<String>>().join(","));
        let members = text(&object).value().unwrap().members("an object").unwrap();
        assert_eq!(members.len(), 200_000);
        assert_eq!(members[199_999].name, "m199999");
        let twice = object.replace("\"m199999\"", "\"m0\"");
        let mistake = text(&twice).value().unwrap().members("an object");
        assert!(
            mistake
                .unwrap_err()
                .to_string()
                .contains("`m0` is given twice")
        );
    }

    #[test]
    fn faults_in_the_syntax_are_underlined() {
        let shown = text("{\"q\":\n [1, NaN]}").value().unwrap_err().to_string();
        assert!(shown.contains("f.json:2:6"), "{shown}");
        assert!(shown.contains("`NaN` is not a JSON value"), "{shown}");
        for odd in ["", "{", "[1,", "é", "{\"a\": \"\\ud800\"}", "nul", "{} {}"] {
            // Whatever it is, there is an answer.
            match text(odd).value() {
                Ok(value) => drop(
                    value
                        .members("an object")
                        .and_then(|m| m[0].value.number("a")),
                ),
                Err(mistake) => assert!(!mistake.to_string().is_empty()),
            }
        }
    }
}
