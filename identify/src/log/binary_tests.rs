//! Logs that are no text: read as the CSV of the same samples is.

use super::*;

mod recorded;

/// Samples of `t`, `q_a`, `u_a`.
fn sample(k: usize) -> [f64; 3] {
    let t = 0.01 * k as f64;
    [t, (3.0 * t).sin(), (5.0 * t).cos()]
}

fn csv(n: usize) -> Log {
    let rows = (0..n).map(|k| {
        let [t, q, u] = sample(k);
        format!("{t},{q},{u}\n")
    });
    let text = format!("t,q_a,u_a\n{}", rows.collect::<String>());
    Log::from_bytes("x", text.as_bytes()).unwrap()
}

fn close(a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len());
    assert!(
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9),
        "{a:?} {b:?}"
    );
}

fn said(log: &Log) -> String {
    let said: Vec<String> = log.warnings.iter().map(ToString::to_string).collect();
    said.join("\n")
}

/// Every file cut short, or with some bytes changed, is read or refused.
fn survives_damage(bytes: &[u8]) {
    survives_damage_with(bytes, None);
}

fn survives_damage_with(bytes: &[u8], map: Option<&Map>) {
    for end in (0..bytes.len()).step_by(1 + bytes.len() / 97) {
        let _ = Log::from_bytes_with("x", &bytes[..end], map);
    }
    let mut state = 1_u64;
    for _ in 0..3000 {
        let mut damaged = bytes.to_vec();
        for _ in 0..3 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let at = 8 + (state >> 33) as usize % (bytes.len() - 8);
            damaged[at] = (state >> 24) as u8;
        }
        if let Ok(log) = Log::from_bytes_with("x", &damaged, map) {
            assert!(log.channels.values().all(|c| c.len() == log.len()));
        }
    }
}

mod parquet {
    use super::*;
    use ::parquet::data_type::{ByteArrayType, DoubleType, Int64Type};
    use ::parquet::file::properties::WriterProperties;
    use ::parquet::file::writer::SerializedFileWriter;
    use ::parquet::schema::parser::parse_message_type;
    use std::sync::Arc;

    fn file(schema: &str, n: usize, empty: bool) -> Vec<u8> {
        let schema = Arc::new(parse_message_type(schema).unwrap());
        let mut bytes = Vec::new();
        let properties = WriterProperties::builder();
        let properties = properties
            .set_compression(::parquet::basic::Compression::SNAPPY)
            .build();
        let mut writer =
            SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties)).unwrap();
        let mut rows = writer.next_row_group().unwrap();
        let stamps: Vec<i64> = (0..n as i64)
            .map(|k| 1_700_000_000_000_000 + 10_000 * k)
            .collect();
        let mut column = rows.next_column().unwrap().unwrap();
        column
            .typed::<Int64Type>()
            .write_batch(&stamps, None, None)
            .unwrap();
        column.close().unwrap();
        for channel in [1, 2] {
            let values: Vec<f64> = (0..n).map(|k| sample(k)[channel]).collect();
            // The first cell of the input is missing if there are empty ones.
            let levels: Vec<i16> = (0..n)
                .map(|k| i16::from(!(empty && channel == 2 && k == 0)))
                .collect();
            let skip = usize::from(empty && channel == 2);
            let mut column = rows.next_column().unwrap().unwrap();
            column
                .typed::<DoubleType>()
                .write_batch(&values[skip..], Some(&levels), None)
                .unwrap();
            column.close().unwrap();
        }
        let text: Vec<::parquet::data_type::ByteArray> = (0..n).map(|_| "auto".into()).collect();
        let mut column = rows.next_column().unwrap().unwrap();
        column
            .typed::<ByteArrayType>()
            .write_batch(&text, None, None)
            .unwrap();
        column.close().unwrap();
        rows.close().unwrap();
        writer.close().unwrap();
        bytes
    }

    const SCHEMA: &str = "message log {
        REQUIRED INT64 t (TIMESTAMP(MICROS, true));
        OPTIONAL DOUBLE q_a;
        OPTIONAL DOUBLE u_a;
        REQUIRED BYTE_ARRAY mode (UTF8);
    }";

    #[test]
    fn reads_as_csv_does() {
        let log = Log::from_bytes("x", &file(SCHEMA, 80, false)).unwrap();
        let expected = csv(80);
        assert_eq!(log.channels, expected.channels);
        let t: Vec<f64> = log.t.iter().map(|t| t - log.t[0]).collect();
        // A microsecond of the year 2023 in 53 bits.
        assert!(t.iter().zip(&expected.t).all(|(a, b)| (a - b).abs() < 1e-6));
        insta::assert_snapshot!(said(&log), @"column `mode` was ignored: line 1 holds `text, a list or a structure`, not a finite number");
    }

    #[test]
    fn faults_have_their_row() {
        let refused = |bytes: &[u8]| {
            Log::from_bytes("bad.parquet", bytes)
                .unwrap_err()
                .to_string()
        };
        insta::assert_snapshot!(refused(&file(SCHEMA, 80, true)), @r#"
        bad.parquet: 1 problem in the log
          line 1, column `u_a`: the cell is empty; expected a finite number
            mend: delete the rows without a measurement (a gap in time is allowed), or say in the log's map how they are filled: `fill = "hold"` or `"linear"`
        "#);
        let renamed = SCHEMA.replace(" t ", " time ");
        assert!(refused(&file(&renamed, 80, false)).contains("is it `time`?"));
        let whole = file(SCHEMA, 80, false);
        let cut = refused(&whole[..whole.len() / 2]);
        assert!(cut.contains("the file is no sound Parquet file: "), "{cut}");
    }

    #[test]
    fn damage_is_survived() {
        survives_damage(&file(SCHEMA, 80, false));
    }
}

mod mcap {
    use super::*;
    use ::mcap::Writer;
    use ::mcap::records::MessageHeader;
    use serde_json::{Value, json};
    use std::collections::BTreeMap;
    use std::io::Cursor;

    /// Messages of topics: encoding, time of logging \[ns\], content.
    fn file(messages: &[(&str, &str, u64, String)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = Writer::new(Cursor::new(&mut bytes)).unwrap();
        for (sequence, (topic, encoding, log_time, text)) in (0..).zip(messages) {
            let channel_id = writer
                .add_channel(0, topic, encoding, &BTreeMap::new())
                .unwrap();
            let header = MessageHeader {
                channel_id,
                sequence,
                log_time: *log_time,
                publish_time: *log_time,
            };
            writer
                .write_to_known_channel(&header, text.as_bytes())
                .unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        bytes
    }

    const START: u64 = 1_700_000_000_000_000_000;

    fn joint_state(k: usize) -> Value {
        let [t, q, u] = sample(k);
        let stamp = START + (1e9 * t).round() as u64;
        json!({
            "header": { "stamp": { "sec": stamp / 1_000_000_000, "nanosec": stamp % 1_000_000_000 } },
            "name": ["a", "b"],
            "position": [q, 2.0 * q],
            "velocity": [],
            "effort": [u, 0.0],
        })
    }

    fn states(n: usize) -> Vec<(&'static str, &'static str, u64, String)> {
        // Logged late and unevenly: the header's stamp counts.
        let logged = |k: usize| START + 10_000_000 * k as u64 + 3_000_000 * (k % 3) as u64;
        let message = |k| {
            (
                "/joint_states",
                "json",
                logged(k),
                joint_state(k).to_string(),
            )
        };
        (0..n).map(message).collect()
    }

    #[test]
    fn joint_states_read_as_csv_does() {
        let log = Log::from_bytes("x", &file(&states(80))).unwrap();
        let expected = csv(80);
        close(&log.t, &expected.t);
        assert_eq!(log.channels["q_a"], expected.channels["q_a"]);
        assert_eq!(log.channels["u_a"], expected.channels["u_a"]);
        assert!(log.channels.contains_key("q_b") && !log.channels.contains_key("dq_a"));
        assert_eq!(said(&log), "");
    }

    #[test]
    fn topics_of_other_rates_are_brought_together() {
        let mut messages = states(200);
        for k in 0..=40 {
            let stamp = |k: u64| json!({ "stamp": { "sec": (START + 50_000_000 * k) / 1_000_000_000, "nanosec": (START + 50_000_000 * k) % 1_000_000_000 } });
            let force = json!({ "header": stamp(k), "load": [3.0 * k as f64] });
            let command = json!({ "header": stamp(k), "torque": k });
            let at = START + 50_000_000 * k;
            messages.push(("/cell", "json", at, force.to_string()));
            messages.push(("/motor", "json", at, command.to_string()));
        }
        messages.push(("/camera", "cdr", START, "\0\0\0".to_owned()));
        messages.push(("/text", "json", START, "no json".to_owned()));
        let map = "columns.u_b = { column = \"/motor.torque\" }
            columns.q_c = { column = \"/cell.load.0\" }";
        let map = Map::parse("x.toml", map).unwrap();
        let log = Log::from_bytes_with("x", &file(&messages), Some(&map)).unwrap();
        let line: Vec<f64> = log.t.iter().map(|t| 60.0 * t).collect();
        close(&log.channels["q_c"], &line);
        let held: Vec<f64> = log.t.iter().map(|t| ((t + 1e-9) / 0.05).floor()).collect();
        close(&log.channels["u_b"], &held);
        insta::assert_snapshot!(said(&log));
    }

    #[test]
    fn files_without_json_say_what_they_have() {
        let refused = |messages: &[(&str, &str, u64, String)]| {
            Log::from_bytes("bad.mcap", &file(messages))
                .unwrap_err()
                .to_string()
        };
        insta::assert_snapshot!(refused(&[("/joint_states", "cdr", 5, "xyz".to_owned())]));
        insta::assert_snapshot!(refused(&[]));
        let mut missing = states(80);
        missing[7].3 = missing[7].3.replace("\"position\":[", "\"pose\":[");
        insta::assert_snapshot!(refused(&missing));
    }

    #[test]
    fn damage_is_survived() {
        survives_damage(&file(&states(80)));
    }
}
