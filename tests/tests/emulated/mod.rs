//! The folder `examples/firmware`, copied as a user would copy it, built and run on a machine.

pub mod table;

use integration_tests::files::root;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where the controller runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Machine {
    /// The one that compiles.
    Host,
    /// A Cortex-M4F in qemu.
    CortexM4,
    /// The Wheelbot's own, in simavr.
    Atmega32u4,
}

impl Machine {
    /// As the Makefile has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Host => "host",
            Self::CortexM4 => "cortex_m4",
            Self::Atmega32u4 => "atmega32u4",
        }
    }

    fn programs(self) -> &'static [&'static str] {
        match self {
            Self::Host => &["make", "cc"],
            Self::CortexM4 => &["make", "arm-none-eabi-gcc", "qemu-system-arm"],
            Self::Atmega32u4 => &["make", "avr-gcc", "simavr"],
        }
    }

    /// Whether it cannot be had here, which is noted.
    pub fn is_missing(self) -> bool {
        left_out::lacks_programs(self.name(), self.programs())
    }
}

/// What one call computed, and what it cost: instructions or cycles.
#[derive(Debug, Clone, PartialEq)]
pub struct Call {
    pub cost: u64,
    pub results: Vec<f32>,
}

/// What a program printed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Replay {
    pub calls: Vec<Call>,
    /// Bytes.
    pub stack: u64,
}

impl Replay {
    /// The lines of a program, between what emulators say.
    pub fn read(text: &str, program: &str) -> Self {
        let mut replay = Self::default();
        for line in text.lines() {
            // simavr colours a line and ends it by a dot.
            let Some((_, line)) = line.split_once(program) else {
                continue;
            };
            let words: Vec<&str> = line.split([' ', '.', '\u{1b}']).collect();
            let number = |word: &str| word.parse().unwrap_or_else(|e| panic!("{line}: {e}"));
            match words[..] {
                ["", "cost", cost, ref results @ ..] => {
                    let bits = results.iter().take_while(|word| word.len() == 8);
                    let bits = bits.map(|word| u32::from_str_radix(word, 16).unwrap());
                    replay.calls.push(Call {
                        cost: number(cost),
                        results: bits.map(f32::from_bits).collect(),
                    });
                }
                ["", "stack", stack, ..] => replay.stack = number(stack),
                _ => {}
            }
        }
        replay
    }

    /// The dearest call.
    pub fn most(&self) -> u64 {
        self.calls.iter().map(|call| call.cost).max().unwrap_or(0)
    }
}

/// A copy of the folder, by itself.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn copied() -> Self {
        let copy = tempfile::tempdir().unwrap();
        let from = root().join("examples/firmware");
        for part in ["", "targets", "generated"] {
            std::fs::create_dir_all(copy.path().join(part)).unwrap();
            for entry in std::fs::read_dir(from.join(part)).unwrap() {
                let path = entry.unwrap().path();
                if path.is_file() {
                    let name = path.file_name().unwrap();
                    std::fs::copy(&path, copy.path().join(part).join(name)).unwrap();
                }
            }
        }
        Self(copy)
    }

    /// Makes a target of the Makefile; both of its outputs.
    pub fn make(&self, target: &str) -> String {
        let mut make = Command::new("make");
        said(make.arg(target).current_dir(self.0.path()))
    }

    /// Builds and runs a program.
    pub fn replay(&self, machine: Machine, program: &str) -> Replay {
        let text = self.make(&format!("run-{}-{program}", machine.name()));
        let replay = Replay::read(&text, program);
        assert!(replay.calls.len() >= 10, "{text}");
        replay
    }

    /// Bytes of flash and of static RAM that a program takes, by `size`.
    pub fn size(&self, machine: Machine, program: &str) -> [u64; 2] {
        let text = self.make(&format!("size-{}", machine.name()));
        let file = format!("{}/{program}.elf", machine.name());
        let line = text.lines().find(|line| {
            let is_row = line.trim_start().starts_with(|c: char| c.is_ascii_digit());
            is_row && line.trim_end().ends_with(&file)
        });
        let line = line.unwrap_or_else(|| panic!("no line of {file}: {text}"));
        let numbers: Vec<u64> = line
            .split_whitespace()
            .map_while(|word| word.parse().ok())
            .collect();
        let [code, data, bss, ..] = numbers[..] else {
            panic!("{line}");
        };
        [code + data, data + bss]
    }
}

/// Both outputs of a command that succeeds.
pub fn said(command: &mut Command) -> String {
    let output = command
        .output()
        .unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let text =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success(), "{command:?}: {}", text.concat());
    text.concat()
}

/// How far results lie from those of another machine, in units of the last place of `f32` at the size
/// of the largest value that a group of results takes; `groups` are so many of them each.
pub fn deviation(found: &[Call], expected: &[Call], groups: &[usize]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let (mut worst, mut first): (f64, usize) = (0.0, 0);
    for &length in groups {
        let places = first..first + length;
        let values = expected
            .iter()
            .flat_map(|call| &call.results[places.clone()]);
        let largest = values.fold(0.0, |most: f64, &x| most.max(f64::from(x).abs()));
        let unit = f64::from(f32::EPSILON) * 2.0_f64.powf(largest.log2().floor());
        for (found, expected) in found.iter().zip(expected) {
            let pairs = found.results[places.clone()]
                .iter()
                .zip(&expected.results[places.clone()]);
            for (&a, &b) in pairs {
                assert!(a.is_finite() && b.is_finite(), "{a} {b}");
                worst = worst.max((f64::from(a) - f64::from(b)).abs() / unit);
            }
        }
        first += length;
    }
    let all = found.iter().chain(expected);
    assert!(all.into_iter().all(|call| call.results.len() == first));
    worst
}

/// The crate `examples/firmware/rust`.
pub fn rust() -> PathBuf {
    root().join("examples/firmware/rust")
}

/// Where cargo puts what tests build of it.
pub fn rust_target() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("firmware")
}
