//! A fingerprint of the texts a model was made from.

use crate::source::Sources;

/// 64-bit FNV-1a (Fowler, Noll, Vo) over the texts, in the order in which they were
/// read, each followed by a zero byte. A line end counts as `\n` however it is
/// stored. It tells versions apart; it is no protection against forgery.
pub fn digest(sources: &Sources) -> u64 {
    const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let texts = sources
        .iter()
        .map(|source| source.text.replace("\r\n", "\n"));
    let bytes = texts.flat_map(|text| text.into_bytes().into_iter().chain([0]));
    bytes.fold(BASIS, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(PRIME)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_value_and_line_ends() {
        // FNV-1a 64 of "a" is af63dc4c8601ec8c (test vectors of the authors); a zero
        // byte multiplies once more.
        let of = |text: &str| {
            let mut sources = Sources::new();
            sources.add("name", text);
            digest(&sources)
        };
        let expected = 0xaf63_dc4c_8601_ec8c_u64.wrapping_mul(0x0000_0100_0000_01b3);
        assert_eq!(of("a"), expected);
        assert_eq!(of("a\r\nb"), of("a\nb"));
        assert_ne!(of("a"), of("b"));
    }
}
