//! `sensor board: m/s^2 = accelerometer(imu) { noise: 0.02; rate: 1000; }`

use super::ast::{SensorStatement, StatementKind};
use super::body::in_braces;
use super::expression::{expression, unit};
use super::stream::{Parsed, Stream};
use crate::diagnostic::{Diagnostic, nearest};

/// What `{ … }` of a sensor may hold.
const ENTRIES: [&str; 3] = ["noise", "resolution", "rate"];

/// A sensor, behind its first word. Also: whether it ends in a brace.
pub(super) fn sensor(stream: &mut Stream<'_>) -> Parsed<(StatementKind, bool)> {
    let name = stream.name("the sensor's name")?;
    let unit = stream.eat(':').then(|| unit(stream)).transpose()?;
    stream.expect('=', "the sensor's name or unit")?;
    let value = expression(stream)?;
    let (mut noise, mut resolution, mut rate) = (None, None, None);
    let braced = in_braces(stream, false, |inner| {
        let key = inner.name("`noise`, `resolution` or `rate`")?;
        inner.expect(':', "this word")?;
        let entry = match key.text.as_str() {
            "noise" => &mut noise,
            "resolution" => &mut resolution,
            "rate" => &mut rate,
            other => {
                let error = Diagnostic::error(key.span, format!("a sensor has no `{other}`"));
                return Err(Box::new(match nearest(other, ENTRIES) {
                    Some(near) => error.help(format!("did you mean `{near}`?")),
                    None => error.help(format!("it has: {}", ENTRIES.join(", "))),
                }));
            }
        };
        if entry.replace(expression(inner)?).is_some() {
            let message = format!("`{}` is given twice", key.text);
            return Err(Box::new(Diagnostic::error(key.span, message)));
        }
        Ok(())
    })?;
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
