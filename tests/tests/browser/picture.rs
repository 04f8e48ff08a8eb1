//! A picture as a browser saves it: PNG, eight bits a channel, not interlaced.

use flate2::read::ZlibDecoder;
use std::collections::BTreeSet;
use std::io::Read;

/// Colours of a picture.
pub struct Picture {
    pub width: usize,
    pub height: usize,
    /// Red, green, blue and perhaps opacity, row by row.
    pixels: Vec<u8>,
    channels: usize,
}

impl Picture {
    /// Reads a PNG file.
    pub fn decode(file: &[u8]) -> Self {
        let mut rest = file.strip_prefix(b"\x89PNG\r\n\x1a\n").expect("a PNG file");
        let (mut header, mut packed) = (Vec::new(), Vec::new());
        while let Some((length, tail)) = rest.split_first_chunk::<4>() {
            let length = u32::from_be_bytes(*length) as usize;
            let (kind, tail) = tail.split_at(4);
            match kind {
                b"IHDR" => header = tail[..length].to_vec(),
                b"IDAT" => packed.extend_from_slice(&tail[..length]),
                _ => {}
            }
            rest = &tail[length + 4..];
        }
        let size = |at: usize| u32::from_be_bytes(header[at..at + 4].try_into().unwrap()) as usize;
        let (width, height) = (size(0), size(4));
        let channels = match header[8..13] {
            [8, 2, 0, 0, 0] => 3,
            [8, 6, 0, 0, 0] => 4,
            ref other => panic!("a kind of PNG that is not read here: {other:?}"),
        };
        let mut filtered = Vec::new();
        ZlibDecoder::new(&packed[..])
            .read_to_end(&mut filtered)
            .unwrap();
        let pixels = unfiltered(&filtered, width * channels, channels);
        assert_eq!(pixels.len(), width * height * channels);
        Self {
            width,
            height,
            pixels,
            channels,
        }
    }

    /// Different colours in the rows of a range.
    pub fn colours(&self, rows: std::ops::Range<usize>) -> usize {
        let row = self.width * self.channels;
        let pixels = self.pixels[rows.start * row..rows.end * row].chunks(self.channels);
        pixels
            .map(|pixel| &pixel[..3])
            .collect::<BTreeSet<_>>()
            .len()
    }
}

/// Undoes the filter of each row (PNG specification, section 9).
fn unfiltered(filtered: &[u8], row: usize, channels: usize) -> Vec<u8> {
    let mut above = vec![0; row];
    let mut pixels = Vec::with_capacity(filtered.len());
    for line in filtered.chunks(row + 1) {
        let (filter, line) = (line[0], &line[1..]);
        let mut current = vec![0; row];
        for (i, &byte) in line.iter().enumerate() {
            let before = |row: &[u8]| if i < channels { 0 } else { row[i - channels] };
            let (a, b, c) = (before(&current), above[i], before(&above));
            let predicted = match filter {
                0 => 0,
                1 => a,
                2 => b,
                3 => ((u16::from(a) + u16::from(b)) / 2) as u8,
                _ => paeth(a, b, c),
            };
            current[i] = byte.wrapping_add(predicted);
        }
        pixels.extend_from_slice(&current);
        above = current;
    }
    pixels
}

/// The neighbour nearest to `a + b - c`.
fn paeth(a: u8, b: u8, c: u8) -> u8 {
    let [x, y, z] = [a, b, c].map(i16::from);
    let near = |value: i16| (x + y - z - value).abs();
    if near(x) <= near(y) && near(x) <= near(z) {
        a
    } else if near(y) <= near(z) {
        b
    } else {
        c
    }
}
