//! The controller in C: what `wheelbot-firmware` does in a tick, recorded and emitted.
//!
//! `examples/firmware` holds the files that come out of it, with what a controller needs around them.

mod arrays;
pub mod readings;
pub mod recorded;

use arrays::{Arguments, Named, results};
use dynamics_codegen::emit::{Array, Routine};
use dynamics_codegen::graph::{ExprId, SymbolId};
use recorded::{Decides, Recorded, record};
use wheelbot_firmware::imu::COUNT;
use wheelbot_firmware::{Balance, Estimator, Firmware, Gains, Memory, Readings, Settings};

/// The routine's name, and its files'.
pub const TICK: &str = "wheelbot_tick";

const AXES: [&str; 3] = ["x", "y", "z"];
const PLANES: [&str; 2] = ["roll", "pitch"];
const WHEELS: [&str; 2] = ["reaction", "rolling"];
/// What the controllers multiply, with the unit of the gain.
const GAINS: [(&str, &str); 4] = [
    ("tilt", "N*m/rad"),
    ("rate", "N*m*s/rad"),
    ("angle", "N*m/rad"),
    ("speed", "N*m*s/rad"),
];

/// One tick of the estimator as the robot has it ([`Settings::published`]) and of both controllers,
/// of which gains and bias are arguments.
///
/// # Errors
/// [`Decides`], which an edit of `wheelbot-firmware` can bring about.
pub fn tick() -> Result<Routine, Decides> {
    let (graph, (arguments, results)) = record(recorded_tick)?;
    Ok(Routine {
        name: TICK.into(),
        meaning:
            "One tick of the Wheelbot's controller, 10 ms after the one before: estimates the \
                  tilt, and balances"
                .into(),
        source: "Recorded from the crate wheelbot-firmware (Firmware::tick_turned), which the\n\
                 simulation runs. To make it again:\n\
                 DYNAMICS_REGENERATE=1 cargo test -p integration-tests --test firmware"
            .into(),
        arguments,
        results,
        graph,
    })
}

fn recorded_tick() -> (Vec<Array<SymbolId>>, Vec<Array<ExprId>>) {
    let mut arguments = Arguments::default();
    let gains = PLANES.map(|plane| GAINS.map(|(of, unit)| (format!("{plane}_{of}_gain"), unit)));
    let [roll, pitch] = arguments.take("gains", "Torque by tilt and wheel, +K x", gains);
    let bias = PLANES.map(|plane| (format!("{plane}_bias"), "rad"));
    let bias = arguments.take_row("bias", "What the estimate shows in balance", bias);
    let counts = WHEELS.map(|wheel| ["step", "way"].map(|of| (format!("{wheel}_{of}"), "count")));
    let meaning = "What the encoders counted since the tick before, and since the first";
    let turned = arguments.take("turned", meaning, counts);
    let gyroscopes = imus("turning", "rad/s");
    let gyroscopes = arguments.take("gyroscopes", "By each IMU, along its axes", gyroscopes);
    let felt = imus("felt", "m/s^2");
    let accelerometers = arguments.take("accelerometers", "By each IMU, along its axes", felt);
    let ahead = WHEELS.map(|wheel| (format!("{wheel}_ahead"), "N*m"));
    let ahead = arguments.take_row("ahead", "Torques added to those of the feedback", ahead);
    let meaning = "What the tick before left; before the first one the tilt, then zeros";
    let before = arguments.take_row("before", meaning, remembered("before"));

    let start = [<Recorded as dynamics::Scalar>::zero(); 2];
    let estimator = Estimator::new(Settings::published(), start);
    let gains = Gains { roll, pitch };
    let firmware = Firmware::new(estimator, Balance { gains, bias });
    let mut firmware = firmware.remembering(memory(before));
    let readings = Readings {
        gyroscopes,
        accelerometers,
        reaction: 0,
        rolling: 0,
    };
    let (tilt, currents) = firmware.tick_turned(&readings, turned, ahead);

    let after = numbers(&firmware.memory());
    let felt = PLANES.map(|plane| (format!("felt_{plane}"), "rad"));
    let motors = WHEELS.map(|wheel| (format!("{wheel}_current"), "A"));
    let results = vec![
        results(
            "after",
            "What the next tick needs",
            remembered("new"),
            after,
        ),
        results("felt", "Tilt by the accelerometers alone", felt, tilt.felt),
        results("currents", "Of the motors", motors, currents),
    ];
    (arguments.arrays, results)
}

fn imus(what: &str, unit: &'static str) -> [[Named; 3]; COUNT] {
    std::array::from_fn(|imu| AXES.map(|axis| (format!("{what}_{}_{axis}", imu + 1), unit)))
}

/// The places of a memory: tilt, rates, and of each wheel the rate with and without the low-pass.
fn remembered(when: &str) -> [Named; 9] {
    let named = [
        ("roll", "rad"),
        ("pitch", "rad"),
        ("roll_rate", "rad/s"),
        ("pitch_rate", "rad/s"),
        ("yaw_rate", "rad/s"),
        ("reaction_rate", "rad/s"),
        ("reaction_raw_rate", "rad/s"),
        ("rolling_rate", "rad/s"),
        ("rolling_raw_rate", "rad/s"),
    ];
    named.map(|(name, unit)| (format!("{when}_{name}"), unit))
}

/// A memory from its places.
pub fn memory<T: Copy>(places: [T; 9]) -> Memory<T> {
    let [roll, pitch, v1, v2, v3, wheels @ ..] = places;
    Memory {
        tilt: [roll, pitch],
        rates: [v1, v2, v3],
        wheels: [[wheels[0], wheels[1]], [wheels[2], wheels[3]]],
    }
}

/// The places of a memory.
pub fn numbers<T: Copy>(memory: &Memory<T>) -> [T; 9] {
    let ([roll, pitch], [v1, v2, v3]) = (memory.tilt, memory.rates);
    let [[a, b], [c, d]] = memory.wheels;
    [roll, pitch, v1, v2, v3, a, b, c, d]
}
