//! The Wheelbot's controller and its equation of motion on the machines that they are for, emulated: they
//! compute what the simulation computes, at the price that `docs/firmware.md` states.

mod emulated;

use dynamics_codegen::emit::Emission;
use dynamics_codegen::{Compiled, Library, Variables, compile_bytes, compile_keeping};
use emulated::table::Table;
use emulated::{Call, Folder, Machine, Replay, deviation, rust, rust_target, said};
use integration_tests::files::{ensure_folder, root};
use std::process::Command;
use wheelbot::firmware;
use wheelbot::firmware::readings::{self, START, single};
use wheelbot::sensing::Sensing;
use wheelbot::trial::Row;
use wheelbot_firmware::{Balance, Estimator, Firmware, Gains, Settings};

const HEADING: &str = "## What it costs";
/// What a program prints, in groups of one size: each number of a tick by itself; of the equation of
/// motion accelerations in m/s², in rad/s², and forces.
const PROGRAMS: [(&str, &[usize]); 2] = [("tick", &[1; 13]), ("motion", &[2, 5, 2])];
/// The same in Rust, which prints nine numbers of a tick.
const RUST_PROGRAMS: [(&str, &[usize]); 2] = [("tick", &[1; 9]), ("motion", &[2, 5, 2])];
/// How far results may lie apart ([`deviation`], docs/firmware.md): C from Rust, where constants are
/// multiplied together in another order; `float` from `double`;
const TICK_BY_RUST: f64 = 5.0;
const MOTION_IN_DOUBLE: f64 = 8.0;
/// and one source on two machines, whose `sinf`, `cosf` and `atan2f` may differ.
const ON_CORTEX_M4: f64 = 1.0;
const ON_AVR: f64 = 8.0;

fn recorded() -> Vec<Row> {
    readings::rows(&mut Sensing::new(1).unwrap()).unwrap()
}

/// `models/wheelbot.model` with all its parameters folded in.
fn folded() -> Compiled {
    let path = "models/wheelbot.model";
    let text = std::fs::read_to_string(root().join(path)).unwrap();
    let library = Library::builtin();
    let whole = compile_bytes(path, text.as_bytes(), &library).unwrap();
    let parameters = whole.model.parameters.iter();
    let values = parameters.map(|p| (p.name.clone(), p.nominal)).collect();
    compile_keeping(path, &text, &library, &Variables::Except(values)).unwrap()
}

#[test]
fn generated_files_are_current() {
    let model = folded();
    let functions = "constrained_dynamics".parse().unwrap();
    let emission = Emission::new(&model, "models/wheelbot.model", &functions).unwrap();
    let files = [
        firmware::tick().unwrap().c(),
        emission.c(),
        readings::files(&recorded()).unwrap(),
    ];
    let files: Vec<(String, String)> = files
        .concat()
        .into_iter()
        .map(|f| (f.name, f.text))
        .collect();
    let folder = root().join("examples/firmware/generated");
    let ending = |ending: &str| {
        let own = files.iter().filter(|(name, _)| name.ends_with(ending));
        own.cloned().collect::<Vec<_>>()
    };
    let wrong: Vec<String> = ["c", "h", "rs"]
        .iter()
        .flat_map(|e| ensure_folder(&folder, &ending(&format!(".{e}")), e))
        .collect();
    assert!(
        wrong.is_empty(),
        "examples/firmware is out of date; regenerate it with\n    DYNAMICS_REGENERATE=1 cargo test -p \
         integration-tests --test firmware\n\n{}",
        wrong.join("\n")
    );
}

/// What the simulation's firmware makes of the record.
fn ticks_of_the_simulation() -> Vec<Call> {
    let balance = Balance {
        gains: Gains::PUBLISHED.cast(),
        bias: [0.0; 2],
    };
    let start = START.map(|angle| angle as f32);
    let mut firmware = Firmware::<f32>::new(Estimator::new(Settings::published(), start), balance);
    let rows = recorded();
    let ticks = rows.iter().map(|row| {
        let (tilt, currents) = firmware.tick(&row.readings, [0.0; 2]);
        let mut results = firmware::numbers(&firmware.memory()).to_vec();
        results.extend(tilt.felt);
        results.extend(currents);
        Call { cost: 0, results }
    });
    ticks.collect()
}

/// The equation of motion of the record in `f64`.
fn motions_of_the_simulation() -> Vec<Call> {
    let rows = recorded();
    let motions = rows.iter().map(|row| {
        let double = |values: &[f64]| {
            single(values)
                .into_iter()
                .map(f64::from)
                .collect::<Vec<_>>()
        };
        let point = dynamics::Point {
            t: 0.0,
            q: double(&row.state.q).try_into().unwrap(),
            v: double(&row.state.v).try_into().unwrap(),
            u: double(&row.inputs[..2]).try_into().unwrap(),
            z: [],
        };
        let nominal = generated::wheelbot::Parameters::nominal();
        let found = generated::wheelbot::constrained_dynamics(&nominal, &point);
        let results = (found.constrained_acceleration.iter()).chain(&found.constrained_multipliers);
        Call {
            cost: 0,
            results: results.map(|&x| x as f32).collect(),
        }
    });
    motions.collect()
}

/// The same source, by way of C and by way of Rust; and the equation of motion in `float` and `double`.
#[test]
fn c_computes_what_the_simulation_does() {
    if Machine::Host.is_missing() {
        return;
    }
    let folder = Folder::copied();
    let expected = [ticks_of_the_simulation(), motions_of_the_simulation()];
    let limits = [TICK_BY_RUST, MOTION_IN_DOUBLE];
    for (((program, groups), expected), limit) in PROGRAMS.into_iter().zip(expected).zip(limits) {
        let found = folder.replay(Machine::Host, program);
        let apart = deviation(&found.calls, &expected, groups);
        println!("{program}: {apart:.2} units of the last place");
        assert!(apart <= limit, "{program}: {apart}");
    }
}

/// What is generated, and the controller around it, by the rules of MISRA C:2012 that cppcheck knows.
#[test]
fn c_keeps_the_rules_of_misra() {
    if left_out::lacks_programs("misra", &["make", "cppcheck"]) {
        return;
    }
    Folder::copied().make("misra");
}

/// Both programs on a machine: results as on the host, costs as in the table.
fn on(machine: Machine, shown: &str, (budget, limit): (u64, f64)) {
    if machine.is_missing() || Machine::Host.is_missing() {
        return;
    }
    let folder = Folder::copied();
    let table = Table::read(HEADING);
    let mut faults = Vec::new();
    for (program, groups) in PROGRAMS {
        let replay = folder.replay(machine, program);
        let expected = folder.replay(Machine::Host, program);
        let apart = deviation(&replay.calls, &expected.calls, groups);
        println!("{shown}, {program}: {apart:.2} units of the last place");
        assert!(apart <= limit, "{program}: {apart}");
        let [flash, ram] = folder.size(machine, program);
        let measured = [replay.most(), replay.stack, flash, ram];
        println!("| {shown} | {program} | {measured:?} |");
        faults.extend(table.fault([shown, program], &measured));
        if machine == Machine::Atmega32u4 {
            assert!(
                flash <= 32 * 1024 && ram + replay.stack <= 2560,
                "{measured:?}"
            );
        }
        if program == "tick" {
            assert!(replay.most() <= budget, "{} of {budget}", replay.most());
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// 5 % of 168 MHz at 1 kHz, if an instruction takes a cycle.
#[test]
fn c_on_a_cortex_m4() {
    on(Machine::CortexM4, "C, Cortex-M4F", (8_400, ON_CORTEX_M4));
}

/// All of 16 MHz at 100 Hz.
#[test]
fn c_on_an_atmega32u4() {
    on(Machine::Atmega32u4, "C, ATmega32U4", (160_000, ON_AVR));
}

/// The target, where cargo can build for it.
const THUMB: &str = "thumbv7em-none-eabihf";

fn lacks_rust() -> bool {
    let core = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", THUMB])
        .output();
    let core = core.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    let there = core.is_ok_and(|folder| std::path::Path::new(&folder).is_dir());
    let wanted = if there { "qemu-system-arm" } else { THUMB };
    left_out::lacks_programs("rust", &[wanted])
}

/// What the crate prints on this machine or on a Cortex-M4F.
fn run_rust(target: Option<&str>) -> String {
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .args(["run", "--release", "--locked"])
        .current_dir(rust());
    cargo.arg("--target-dir").arg(rust_target());
    // Flags for this machine are none for the other.
    cargo
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS");
    if let Some(target) = target {
        cargo.args(["--target", target]);
    }
    said(&mut cargo)
}

/// `no_std` Rust: bit by bit what it computes on the host.
#[test]
fn rust_on_a_cortex_m4() {
    if left_out::too_slow() {
        return;
    }
    if lacks_rust() {
        return;
    }
    let (host, text) = (run_rust(None), run_rust(Some(THUMB)));
    let (table, shown) = (Table::read(HEADING), "Rust, Cortex-M4F");
    let mut faults = Vec::new();
    for (program, groups) in RUST_PROGRAMS {
        let [found, expected] = [&text, &host].map(|text| Replay::read(text, program));
        assert_eq!(
            deviation(&found.calls, &expected.calls, groups),
            0.0,
            "{program}"
        );
        // Stack, flash and RAM are not measured.
        let measured = [found.most(), 0, 0, 0];
        println!("| {shown} | {program} | {measured:?} |");
        faults.extend(table.fault([shown, program], &measured));
        if program == "tick" {
            assert!(found.most() <= 8_400, "{measured:?}");
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
