//! Messages in JSON.

use super::topics::{LONGEST_LIST, Topic};
use serde_json::Value;

/// Takes in a message.
///
/// # Errors
/// If it is no JSON.
pub(super) fn read(bytes: &[u8], message: &mut Topic) -> Result<(), String> {
    let value =
        serde_json::from_slice(bytes).map_err(|_| "a message of it is no JSON".to_owned())?;
    take(&value, message);
    Ok(())
}

/// Every number and text of a value. `serde_json` bounds the depth.
fn take(value: &Value, message: &mut Topic) {
    match value {
        Value::Number(number) => message.number(number.as_f64().unwrap_or(f64::NAN)),
        Value::Bool(flag) => message.number(f64::from(u8::from(*flag))),
        Value::String(text) => message.text(text),
        Value::Object(fields) => {
            for (name, field) in fields {
                let before = message.enter(name);
                take(field, message);
                message.leave(before);
            }
        }
        Value::Array(items) if items.len() <= LONGEST_LIST => {
            for (index, item) in items.iter().enumerate() {
                let before = message.enter(&index.to_string());
                take(item, message);
                message.leave(before);
            }
        }
        Value::Array(_) | Value::Null => {}
    }
}
