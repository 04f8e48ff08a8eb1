//! The envelope of saved files: format name, version, checksum, body.

use crate::error::{GpError, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Version of the files this build writes, and the only one it reads.
pub const VERSION: u64 = 1;

#[derive(Serialize)]
struct FileRef<'a, T> {
    format: &'a str,
    version: u64,
    checksum: String,
    body: &'a T,
}

fn unwritable(e: serde_json::Error) -> GpError {
    GpError::Saved(format!("cannot be written: {e}"))
}

/// `body` as text. Errors: a number JSON cannot hold.
pub(crate) fn write<T: Serialize>(format: &str, body: &T) -> Result<String> {
    let file = FileRef {
        format,
        version: VERSION,
        checksum: checksum(body)?,
        body,
    };
    serde_json::to_string(&file).map_err(unwritable)
}

/// The body of a file, after `check` accepted it. Errors name what is wrong.
pub(crate) fn read<T: Serialize + DeserializeOwned>(
    format: &str,
    text: &str,
    check: impl Fn(&T) -> Result<()>,
) -> Result<T> {
    let value: Value = serde_json::from_str(text).map_err(|e| {
        GpError::Saved(if e.is_eof() {
            format!(
                "the file is truncated: it ends at line {}, column {}; copy it again or retrain",
                e.line(),
                e.column()
            )
        } else {
            format!("not a JSON file: {e}")
        })
    })?;
    match value.get("format").and_then(Value::as_str) {
        Some(found) if found == format => {}
        Some(found) => {
            return Err(GpError::Saved(format!(
                "expected \"format\": \"{format}\", found \"{found}\"; read it as what it is"
            )));
        }
        None => {
            return Err(GpError::Saved(format!(
                "expected \"format\": \"{format}\"; this is some other JSON file"
            )));
        }
    }
    version(&value)?;
    let body = value
        .get("body")
        .ok_or_else(|| GpError::Saved("the field \"body\" is missing".into()))?;
    let body = T::deserialize(body).map_err(|e| GpError::Saved(format!("body: {e}")))?;
    check(&body)?;
    let (found, stated) = (
        checksum(&body)?,
        value.get("checksum").and_then(Value::as_str),
    );
    if stated != Some(found.as_str()) {
        return Err(GpError::Saved(format!(
            "checksum {found} does not match the stated {}; the body was changed",
            stated.unwrap_or("(none)")
        )));
    }
    Ok(body)
}

fn version(value: &Value) -> Result<()> {
    match value.get("version").and_then(Value::as_u64) {
        Some(VERSION) => Ok(()),
        Some(v) if v < VERSION => Err(GpError::Saved(format!(
            "version {v} is older than {VERSION}, the one this build reads; retrain, or convert it with the build that wrote it"
        ))),
        Some(v) => Err(GpError::Saved(format!(
            "version {v} is newer than {VERSION}, the one this build reads; update the program"
        ))),
        None => Err(GpError::Saved(
            "the field \"version\" is missing or not a number".into(),
        )),
    }
}

/// FNV-1a over the canonical text of the body.
fn checksum<T: Serialize>(body: &T) -> Result<String> {
    let text = serde_json::to_string(body).map_err(unwritable)?;
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for byte in text.bytes() {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    Ok(format!("{hash:016x}"))
}
