//! `sensor board: m/s^2 = accelerometer(imu) { noise: 0.02; rate: 1000; }`

use super::ast::{SensorStatement, StatementKind};
use super::body::settings;
use super::expression::{expression, unit};
use super::stream::{Parsed, Stream};

/// What `{ … }` of a sensor may hold.
const ENTRIES: [&str; 3] = ["noise", "resolution", "rate"];

/// A sensor, behind its first word. Also: whether it ends in a brace.
pub(super) fn sensor(stream: &mut Stream<'_>) -> Parsed<(StatementKind, bool)> {
    let name = stream.name("the sensor's name")?;
    let unit = stream.eat(':').then(|| unit(stream)).transpose()?;
    stream.expect('=', "the sensor's name or unit")?;
    let value = expression(stream)?;
    let words = "`noise`, `resolution` or `rate`";
    let ([noise, resolution, rate], braced) = settings(stream, "sensor", words, ENTRIES)?;
    let statement = SensorStatement {
        name,
        unit,
        value,
        noise,
        resolution,
        rate,
    };
    Ok((StatementKind::Sensor(Box::new(statement)), braced))
}
