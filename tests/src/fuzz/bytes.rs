//! Damage to bytes, as disks and transfers do it.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The longest piece that is deleted or doubled.
const PIECE: usize = 64;

/// Does `count` damages.
pub fn damage(rng: &mut ChaCha8Rng, bytes: &mut Vec<u8>, count: usize) {
    for _ in 0..count {
        if bytes.is_empty() {
            bytes.push(rng.random());
            continue;
        }
        let at = rng.random_range(0..bytes.len());
        let end = (at + rng.random_range(1..=PIECE)).min(bytes.len());
        match rng.random_range(0..7_u32) {
            0 => bytes[at] ^= 1 << rng.random_range(0..8_u32),
            1 => bytes[at] = rng.random(),
            2 => bytes.insert(at, rng.random()),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let piece = bytes[at..end].to_vec();
                drop(bytes.splice(at..at, piece));
            }
            5 => bytes.truncate(at),
            _ => bytes[at..end].fill(0),
        }
    }
}
