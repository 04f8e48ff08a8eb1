//! Lines of a file or of standard input, in batches.

use crate::json::Text;
use crate::mistake::Mistake;
use crate::parameters;
use crate::state::SHAPE;
use dynamics_codegen::file::{self, Limit};
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// A line may have this many bytes.
const MAX_LINE: usize = 16 << 20;

/// States are answered as they are read: a file of them may have any length.
const LIMIT: Limit = Limit {
    what: "a file of states",
    bytes: u64::MAX,
};

/// A line that is not blank.
#[derive(Debug, Clone)]
pub struct Line {
    /// What the user calls the file.
    pub file: String,
    /// Its number, from one.
    pub number: usize,
    content: String,
}

impl Line {
    /// The line's text at its place.
    pub fn text(&self) -> Text<'_> {
        Text {
            file: &self.file,
            first_line: self.number,
            text: &self.content,
            shape: SHAPE,
        }
    }
}

/// Reads lines.
pub struct Lines {
    file: String,
    reader: BufReader<Box<dyn Read>>,
    interactive: bool,
    number: usize,
}

impl Lines {
    /// The lines of a file.
    ///
    /// # Errors
    /// If it cannot be opened, or is no regular file.
    pub fn open(path: &Path) -> Result<Self, Mistake> {
        let file = file::open(path, LIMIT).map_err(|error| {
            Mistake::unreadable(path, &error).help("`--states -` reads standard input")
        })?;
        Ok(Self::new(path.display().to_string(), Box::new(file), false))
    }

    /// The lines of standard input. A batch ends where the input does for the moment,
    /// so that whoever feeds us may wait for the answer before going on.
    pub fn stdin() -> Self {
        Self::new("standard input".to_string(), Box::new(io::stdin()), true)
    }

    fn new(file: String, reader: Box<dyn Read>, interactive: bool) -> Self {
        Self {
            file,
            reader: BufReader::with_capacity(1 << 16, reader),
            interactive,
            number: 0,
        }
    }

    /// Up to `count` lines that are not blank; `None` at the end of the file.
    ///
    /// # Errors
    /// If the file cannot be read, is not UTF-8, or has a line without end.
    pub fn batch(&mut self, count: usize) -> Result<Option<Vec<Line>>, Mistake> {
        let mut batch = Vec::new();
        while batch.len() < count {
            let Some(content) = self.next()? else { break };
            if !content.trim().is_empty() {
                batch.push(Line {
                    file: self.file.clone(),
                    number: self.number,
                    content,
                });
            }
            let nothing_waits = !self.reader.buffer().contains(&b'\n');
            if self.interactive && nothing_waits && !batch.is_empty() {
                break;
            }
        }
        Ok((!batch.is_empty()).then_some(batch))
    }

    fn next(&mut self) -> Result<Option<String>, Mistake> {
        let mut bytes = Vec::new();
        let mut limited = (&mut self.reader).take(MAX_LINE as u64);
        limited
            .read_until(b'\n', &mut bytes)
            .map_err(|error| Mistake::unreadable(Path::new(&self.file), &error))?;
        if bytes.is_empty() {
            return Ok(None);
        }
        self.number += 1;
        if bytes.len() == MAX_LINE {
            let message = format!("line {} of `{}` has no end", self.number, self.file);
            return Err(Mistake::new(message).help("one state is one line of JSON"));
        }
        let line = parameters::text(&self.file, &bytes).map_err(|_| {
            let message = format!("line {} of `{}` is not UTF-8 text", self.number, self.file);
            Mistake::new(message).help("save it as UTF-8")
        })?;
        Ok(Some(line.trim_end_matches(['\r', '\n']).to_string()))
    }
}
