//! The same failure of a shorter input.

use super::input::Input;
use std::ops::Range;

/// Inputs that are tried for a shorter one.
const TRIES: usize = 600;

/// Leaves out pieces of an input, from half of it down to one byte, as long as `fails` says
/// that what is left fails in the same way.
pub fn shrink(input: &Input, mut fails: impl FnMut(&Input) -> bool) -> Input {
    let mut shortest = input.clone();
    let mut tries = TRIES;
    let mut piece = input.bytes.len().div_ceil(2);
    while piece > 0 && tries > 0 {
        let mut start = 0;
        while start < shortest.bytes.len() && tries > 0 {
            let end = (start + piece).min(shortest.bytes.len());
            let shorter = without(&shortest, start..end);
            tries -= 1;
            if fails(&shorter) {
                shortest = shorter;
            } else {
                start = end;
            }
        }
        piece /= 2;
    }
    shortest
}

fn without(input: &Input, piece: Range<usize>) -> Input {
    let mut shorter = input.clone();
    shorter.bytes.drain(piece);
    shorter
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fuzz::Kind;

    #[test]
    fn what_does_not_matter_goes() {
        let input = Input {
            bytes: format!("{}x{}y{}", "a".repeat(100), "b".repeat(333), "c".repeat(7)).into(),
            ..Input::new(Kind::Model, 0, 0)
        };
        let both = |input: &Input| {
            let at = |byte: u8| input.bytes.iter().position(|&b| b == byte);
            matches!((at(b'x'), at(b'y')), (Some(x), Some(y)) if x < y)
        };
        assert_eq!(shrink(&input, both).bytes, b"xy");
    }
}
