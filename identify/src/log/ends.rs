//! The ends of a text that was not written to its end, or not from its beginning: bytes that no
//! text has, as a serial line that starts in the middle, a file that was allocated and not filled,
//! or a lost power supply leave them. Between its ends a text has none.

use super::warning::Warning;

/// Most bytes at the start that are looked through for the first line of text.
const START: usize = 1 << 16;

/// A text without what is garbage at its ends.
#[derive(Debug)]
pub(super) struct Sound<'a> {
    /// The text.
    pub text: &'a str,
    /// The line of the file that it begins on, counted from 1.
    pub line: u64,
    /// What was dropped.
    pub warnings: Vec<Warning>,
}

/// The text between garbage.
///
/// # Errors
/// The offset of the first byte in between that is not UTF-8.
pub(super) fn sound(bytes: &[u8]) -> Result<Sound<'_>, usize> {
    let mut warnings = Vec::new();
    let begin = start(bytes);
    let line = 1 + line_ends(&bytes[..begin]);
    if begin > 0 {
        warnings.push(Warning::DroppedStart { bytes: begin, line });
    }
    let end = begin + end(&bytes[begin..]);
    if end < bytes.len() {
        warnings.push(Warning::DroppedEnd {
            bytes: bytes.len() - end,
            line: line + line_ends(&bytes[begin..end]),
        });
    }
    let text = std::str::from_utf8(&bytes[begin..end]).map_err(|e| begin + e.valid_up_to())?;
    Ok(Sound {
        text,
        line,
        warnings,
    })
}

fn line_ends(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|byte| **byte == b'\n').count() as u64
}

/// Whether a byte stands in no text.
fn is_control(byte: u8) -> bool {
    (byte < b' ' && !matches!(byte, b'\t' | b'\n' | b'\r')) || byte == 0x7f
}

/// The first byte that is in no text, a control character or not UTF-8.
fn first_bad(bytes: &[u8]) -> Option<usize> {
    let valid = match std::str::from_utf8(bytes) {
        Ok(_) => bytes.len(),
        Err(error) => error.valid_up_to(),
    };
    let control = bytes[..valid].iter().position(|byte| is_control(*byte));
    control.or_else(|| (valid < bytes.len()).then_some(valid))
}

/// Where the text begins: behind lines at the start of which one at least has control characters.
/// A header in another encoding has none, and is no garbage.
fn start(bytes: &[u8]) -> usize {
    let (mut begin, mut controls) = (0, false);
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        let Some(bad) = first_bad(line).filter(|_| begin < START) else {
            break;
        };
        let last = line.iter().rposition(|byte| is_control(*byte));
        controls |= last.is_some();
        // The header may follow in the same line.
        let rest = &line[last.map_or(bad, |last| last + 1)..];
        let next = bytes[begin + line.len()..]
            .split(|byte| *byte == b'\n')
            .next();
        if controls && first_bad(rest).is_none() && next.is_some_and(|row| alike(rest, row)) {
            begin += line.len() - rest.len();
            break;
        }
        begin += line.len();
    }
    match controls && begin < bytes.len() {
        true => begin,
        false => 0,
    }
}

/// Where the text ends: before the first bad byte behind which no row of text stands.
fn end(bytes: &[u8]) -> usize {
    let Some(bad) = first_bad(bytes) else {
        return bytes.len();
    };
    let sound = &bytes[..bad];
    let whole = sound.iter().rposition(|byte| *byte == b'\n').unwrap_or(0);
    let row = sound[..whole]
        .rsplit(|byte| *byte == b'\n')
        .next()
        .unwrap_or_default();
    let mut behind = bytes[bad..].split(|byte| *byte == b'\n').skip(1);
    let goes_on = behind.any(|line| first_bad(line).is_none() && alike(line, row));
    match goes_on || whole == 0 {
        true => bytes.len(),
        false => bad,
    }
}

/// Whether two lines have equally many marks between their cells, and any.
fn alike(a: &[u8], b: &[u8]) -> bool {
    let count = |line: &[u8]| {
        [b',', b';', b'\t'].map(|mark| line.iter().filter(|byte| **byte == mark).count())
    };
    count(a) == count(b) && count(a) != [0; 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "t,q\n0,1\n1,2\n";

    fn found(before: &[u8], after: &[u8]) -> (String, u64) {
        let bytes = [before, TEXT.as_bytes(), after].concat();
        let sound = sound(&bytes).unwrap();
        let expected = usize::from(!before.is_empty()) + usize::from(!after.is_empty());
        assert_eq!(sound.warnings.len(), expected, "{:?}", sound.warnings);
        (sound.text.to_owned(), sound.line)
    }

    #[test]
    fn garbage_at_the_ends_is_dropped() {
        let is = |line| (TEXT.to_owned(), line);
        assert_eq!(found(b"", b""), is(1));
        assert_eq!(found(b"\0\0\0", b""), is(1));
        assert_eq!(found(b"\x89\xf3\n\x01,\xff\n", b""), is(3));
        assert_eq!(found(b"7,\x013\n", b"\0\0\n\0"), is(2));
        assert_eq!(found(b"", b"\xff\xfe,\n\x80\n"), is(1));
        // The row in front of it is left to be judged as a row.
        assert_eq!(found(b"", b"2,3\0\0\0").0, format!("{TEXT}2,3"));
    }

    #[test]
    fn garbage_in_the_middle_stays() {
        let bytes = [TEXT.as_bytes(), b"\xff\n", b"2,3\n"].concat();
        assert_eq!(sound(&bytes).unwrap_err(), TEXT.len());
        let bytes = [TEXT.as_bytes(), b"\0,1\n", b"2,3\n"].concat();
        let sound = sound(&bytes).unwrap();
        assert_eq!((sound.text.len(), sound.warnings.len()), (bytes.len(), 0));
    }

    /// A header in Latin-1 is a header that cannot be read, not garbage.
    #[test]
    fn other_encodings_are_no_garbage() {
        assert_eq!(sound(b"t,winkel [\xb0]\n0,1\n").unwrap_err(), 10);
        assert_eq!(sound(b"\xe9,t\n").unwrap_err(), 0);
    }
}
