//! Messages and warnings, on logs with one thing wrong each.

use super::*;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

/// A log of `n` samples at 100 Hz of coordinate and input `a`.
pub(super) fn good(n: usize) -> String {
    let mut text = String::from("t,q_a,u_a\n");
    for k in 0..n {
        text += &row(k);
        text.push('\n');
    }
    text
}

/// A log of sixty samples with these columns, the first of which is `t`; all others are one.
pub(super) fn headed(header: &str) -> Log {
    let columns = header.matches(',').count();
    let rows = (0..60).map(|k| format!("{}{}\n", 0.01 * f64::from(k), ",1".repeat(columns)));
    let text = format!("{header}\n{}", rows.collect::<String>());
    Log::from_bytes("test.csv", text.as_bytes()).unwrap()
}

fn row(k: usize) -> String {
    let t = 0.01 * k as f64;
    format!("{t:.2},{:.7},{:.7}", (3.0 * t).sin(), (5.0 * t).cos())
}

/// A good log with the given lines (counted from 1) replaced.
fn with_lines(n: usize, changes: &[(usize, &str)]) -> String {
    let text = good(n);
    let mut lines: Vec<&str> = text.lines().collect();
    for (line, replacement) in changes {
        lines[line - 1] = replacement;
    }
    lines.join("\n")
}

fn refused(bytes: impl AsRef<[u8]>) -> String {
    match Log::from_bytes("bad.csv", bytes.as_ref()) {
        Ok(log) => panic!("accepted {} samples", log.len()),
        Err(error) => error.to_string(),
    }
}

pub(super) fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|name| (*name).to_owned()).collect()
}

fn gzip(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(text.as_bytes()).unwrap();
    encoder.finish().unwrap()
}

/// `trace model run_1*` takes what explains a log's columns, too.
#[test]
fn what_explains_a_log_is_no_log() {
    let error = Log::read("run_1.toml").unwrap_err().to_string();
    insta::assert_snapshot!(error, @r"
    run_1.toml: this says how the columns of a log are read, and is no log itself
      mend: leave it out: it is read with the log of its name, or give it with --map
    ");
}

#[test]
fn columns_without_a_file_are_a_log() {
    let file = Log::from_bytes("x", good(80).as_bytes()).unwrap();
    let mut columns: Vec<(String, Vec<f64>)> = file.channels.clone().into_iter().collect();
    columns.insert(0, ("t".to_owned(), file.t.clone()));
    let same = Log::from_columns("x", columns.clone(), None).unwrap();
    assert_eq!((&same.t, &same.channels), (&file.t, &file.channels));
    columns[1].1[7] = f64::NAN;
    let error = Log::from_columns("x", columns.clone(), None).unwrap_err();
    assert!(error.to_string().contains("q_a"), "{error}");
    columns[1].1.truncate(7);
    let error = Log::from_columns("x", columns, None).unwrap_err();
    assert!(error.to_string().contains("line 8"), "{error}");
}

#[test]
fn dialects_of_csv_read_alike() {
    let plain = Log::from_bytes("x", good(80).as_bytes()).unwrap();
    let spaced = good(80).replace(',', " , ").replace('\n', "\n\n");
    let dialects = [
        gzip(&good(80)),
        format!("\u{feff}{}", good(80)).into_bytes(),
        gzip(&format!("\u{feff}{}", good(80))),
        good(80).replace('\n', "\r\n").into_bytes(),
        good(80).replace(',', ";").into_bytes(),
        good(80).replace(',', "\t").into_bytes(),
        spaced.into_bytes(),
        format!("# made by hand\n\n{}", good(80)).into_bytes(),
        good(80)
            .replace("t,q_a,u_a", "\"t\",\"q_a\",\"u_a\"")
            .into_bytes(),
        good(80).trim_end().as_bytes().to_vec(),
    ];
    for bytes in dialects {
        let log = Log::from_bytes("x", &bytes).unwrap();
        assert_eq!((&log.t, &log.channels), (&plain.t, &plain.channels));
    }
}

#[test]
fn lines_are_those_of_the_file() {
    let text = format!("# one\n\n{}", good(60).replace("0.30,", "# x\r\n\r\n0.30,"));
    let log = Log::from_bytes("x", text.as_bytes()).unwrap();
    assert_eq!((log.lines[0], log.lines[29], log.lines[30]), (4, 33, 36));
    let bad = text.replace("0.30,", "0.30,x");
    assert!(refused(bad).contains("line 36, column `q_a`: found `x"));
}

#[test]
fn no_content() {
    insta::assert_snapshot!(refused(""));
    insta::assert_snapshot!(refused("# nothing but a comment\n\n"));
    insta::assert_snapshot!(refused("t,q_a,u_a\n"));
    insta::assert_snapshot!(refused(good(12)));
}

#[test]
fn foreign_content() {
    insta::assert_snapshot!("foreign_content", refused(b"PK\x03\x04abc"));
    insta::assert_snapshot!("foreign_content-2", refused(b"\xff\xfet\0,\0"));
    let mut bytes = good(60).into_bytes();
    bytes[100] = 0xe9;
    insta::assert_snapshot!("foreign_content-3", refused(bytes));
}

#[test]
fn damaged_gzip() {
    let whole = gzip(&good(3000));
    insta::assert_snapshot!(refused(&whole[..whole.len() / 2]));
    let mut damaged = whole.clone();
    let last = damaged.len() - 6;
    damaged[last] ^= 0xff;
    insta::assert_snapshot!(refused(damaged));
}

/// A small file that stands for more numbers than there is room for, and one of a million
/// columns: neither is read to its end.
#[test]
fn more_than_there_is_room_for() {
    let mut rows = "0,0\n".repeat(1 << 16);
    rows.insert_str(0, "t,q_a\n");
    let piece = gzip(&rows);
    insta::assert_snapshot!(refused(piece.repeat(257)));
    insta::assert_snapshot!(refused(format!("t,q_a{}\n", ",".repeat(1_000_000))));
}

#[test]
fn bad_header() {
    let rows = good(60);
    let (_, rows) = rows.split_once('\n').unwrap();
    insta::assert_snapshot!(refused(rows));
    insta::assert_snapshot!(refused(format!("t,q_a,q_a\n{rows}")));
    insta::assert_snapshot!(refused(format!("Time,q_a,u_a\n{rows}")));
}

/// What a recorder that was stopped, or a line that was cut, leaves at the ends.
#[test]
fn garbage_at_the_ends_is_dropped() {
    let whole = Log::from_bytes("x", good(80).as_bytes()).unwrap();
    let read = |text: &[u8]| {
        let log = Log::from_bytes("x", text).unwrap();
        let said: Vec<String> = log.warnings.iter().map(ToString::to_string).collect();
        (log, said.join("\n"))
    };
    let (log, said) = read(&[b"\x07\xff\0,\x99\n", good(80).as_bytes(), &[0; 40]].concat());
    assert_eq!((&log.t, &log.channels), (&whole.t, &whole.channels));
    assert_eq!(log.lines[0], 3);
    insta::assert_snapshot!(said, @r"
    the log begins with 6 bytes that are no text: they were dropped, it is read from line 2 on
    the log ends with 40 bytes that are no text, from line 83 on: they were dropped
    ");
    let text = good(81);
    for cut in [12, 3] {
        let (log, said) = read(&text.as_bytes()[..text.len() - cut]);
        let at = text.len() - cut;
        let complete = text[..at].ends_with(|c: char| c.is_ascii_digit()) && cut == 3;
        assert_eq!(log.len(), 80 + usize::from(complete), "{said}");
    }
    let cut = &text[..text.rfind(',').unwrap()];
    insta::assert_snapshot!(read(cut.as_bytes()).1, @"line 82, the last one, breaks off (`0.80,0.6754632`): it was dropped");
    insta::assert_snapshot!(read(format!("{cut},-").as_bytes()).1, @"line 82, the last one, breaks off (`0.80,0.6754632,-`): it was dropped");
}

/// A row that is too short, or what is no text, between rows that are sound.
#[test]
fn garbage_in_the_middle_is_refused() {
    assert!(refused(with_lines(60, &[(30, "0.28,1")])).contains("line 30: the row has 2 cells"));
    let mut bytes = good(60).into_bytes();
    bytes[200] = 0;
    assert!(refused(bytes).contains("expected a finite number"));
    // A quote that nobody closes swallows rows, which are not one row that was cut off.
    let open = with_lines(60, &[(30, "0.28,\"1,1")]);
    assert!(refused(open).contains("the row has 2 cells"));
}

#[test]
fn bad_cells_are_reported_together() {
    insta::assert_snapshot!(refused(with_lines(
        60,
        &[
            (3, "0.01,abc,1"),
            (5, "0.03,nan,1"),
            (7, "0.05,,1"),
            (9, "0.07,1,-inf"),
            (11, "0.09,1"),
            (13, "0.11,1,2,3"),
            (15, "0.13,1e999,2"),
        ],
    )));
}

#[test]
fn only_ten_are_listed() {
    let text = good(60).replace("0.2", "x");
    insta::assert_snapshot!(refused(text));
}

#[test]
fn decimal_comma() {
    let text = good(60).replace(',', ";").replace('.', ",");
    let message = refused(text);
    insta::assert_snapshot!(message.lines().take(3).collect::<Vec<_>>().join("\n"));
}

#[test]
fn disordered_time() {
    insta::assert_snapshot!(refused(with_lines(
        60,
        &[(20, "0.05,1,1"), (30, "0.27,1,1")]
    )));
}

#[test]
fn repeated_rows_are_dropped_and_reported() {
    let again = format!("{}\n{}", row(20), row(20));
    let log = Log::from_bytes("x", with_lines(60, &[(22, &again)]).as_bytes()).unwrap();
    assert_eq!(log.len(), 60);
    insta::assert_snapshot!(log.warnings[0]);
}

#[test]
fn missing_columns_name_the_nearest() {
    let text = good(60).replace("t,q_a,u_a", "t,q_joint1,u_Joint1");
    let log = Log::from_bytes("bad.csv", text.as_bytes()).unwrap();
    let wanted = names(&["joint_1", "elbow"]);
    let error = log.select(&wanted, &names(&["joint1"])).unwrap_err();
    insta::assert_snapshot!(error);
}

#[test]
fn unreadable_path() {
    let error = Log::read("no/such/file.csv").unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("no/such/file.csv: cannot read the log: ")
    );
}

#[test]
fn extra_columns_may_hold_text() {
    let mut text = String::from("t,q_a,u_a,mode,current,\n");
    for k in 0..60 {
        text += &format!("{},auto,{k},\n", row(k));
    }
    let log = Log::from_bytes("x", text.as_bytes()).unwrap();
    assert_eq!(log.columns(), ["t", "current", "q_a", "u_a"]);
    let shown: Vec<String> = log.warnings.iter().map(ToString::to_string).collect();
    insta::assert_snapshot!(shown.join("\n"));
}

/// Warnings for a log of coordinate `a` (and `b`, moving) and input `a`.
fn warned(t: impl Fn(usize) -> f64, a: impl Fn(f64) -> f64, u: impl Fn(f64) -> f64) -> Record {
    let mut text = String::from("t,q_a,q_b,u_a\n");
    for k in 0..1000 {
        let t = t(k);
        text += &format!("{t},{},{},{}\n", a(t), (2.0 * t).sin(), u(t));
    }
    let log = Log::from_bytes("x", text.as_bytes()).unwrap();
    log.select(&names(&["a", "b"]), &names(&["a"])).unwrap()
}

fn even(k: usize) -> f64 {
    0.01 * k as f64
}

fn shown(record: &Record) -> String {
    let shown: Vec<String> = record.warnings.iter().map(ToString::to_string).collect();
    shown.join("\n")
}

#[test]
fn a_healthy_log_has_no_warning() {
    let record = warned(even, |t| 20.0 * t.sin(), |t| (3.0 * t).cos());
    assert_eq!(shown(&record), "");
    assert_eq!(record.segments(), vec![0..1000]);
}

#[test]
fn wrapped_angles_are_unwrapped() {
    let angle = |t: f64| 12.0 * (0.7 * t).sin();
    let wrapped = |t: f64| (angle(t) + 3.0).rem_euclid(std::f64::consts::TAU) - 3.0;
    let record = warned(even, wrapped, |t| (3.0 * t).cos());
    for (t, q) in record.t.iter().zip(&record.q[0]) {
        assert!((q - angle(*t)).abs() < 1e-9, "t = {t}");
    }
    insta::assert_snapshot!(shown(&record));
}

#[test]
fn gaps_and_jitter() {
    let gappy = |k: usize| {
        let jitter = if k.is_multiple_of(3) { 0.002 } else { 0.0 };
        even(k) + jitter + if k > 400 { 1.5 } else { 0.0 } + if k > 700 { 0.1 } else { 0.0 }
    };
    let record = warned(gappy, |t| 20.0 * t.sin(), |t| (3.0 * t).cos());
    assert_eq!(record.segments(), vec![0..401, 401..701, 701..1000]);
    insta::assert_snapshot!(shown(&record));
}

#[test]
fn stuck_quantised_saturated() {
    let stuck = |t: f64| if t > 4.0 && t < 7.0 { 0.5 } else { t.sin() };
    let limited = |t: f64| (2.0 * (3.0 * t).cos()).clamp(-1.5, 1.5);
    insta::assert_snapshot!(shown(&warned(even, stuck, limited)));
    let coarse = |t: f64| (t.sin() / 0.02).round() * 0.02;
    insta::assert_snapshot!(shown(&warned(even, coarse, |_| 0.0)));
    let held = |t: f64| (((t + 1e-9) / 0.04).floor() * 0.04).sin();
    let milliseconds = |k: usize| 1000.0 * even(k);
    insta::assert_snapshot!(shown(&warned(even, held, |t| t.cos())));
    insta::assert_snapshot!(shown(&warned(milliseconds, |t| t * t, |t| t.cos())));
}

/// An input column that stops while the machine goes on, and one that was switched off.
#[test]
fn an_input_that_stops_is_told_from_one_that_is_off() {
    let rests = |value: f64| {
        let input = move |t: f64| if t > 6.0 { value } else { (3.0 * t).cos() };
        shown(&warned(even, |t| 20.0 * t.sin(), input))
    };
    insta::assert_snapshot!(rests(0.3), @"`u_a` stands still from t = 6.010000 s to 9.990000 s (399 samples) while the machine moves");
    assert_eq!(rests(0.0), "");
}

#[test]
fn a_column_that_is_another_joints_is_told() {
    let twice = warned(even, |t| (2.0 * t).sin(), |t| (2.0 * t).sin());
    insta::assert_snapshot!(shown(&twice), @"`q_a` and `q_b` say the same in every row: one of them is probably the other's column");
}

/// Nanoseconds since 1970, as recorders of robots stamp.
#[test]
fn stamps_that_cannot_be_seconds() {
    let mut text = String::from("t,q_a,u_a\n");
    for k in 0..60_u64 {
        let stamp = 1_760_000_000_000_000_000 + 10_000_000 * k;
        text += &format!("{stamp},{},0\n", 0.1 * k as f64);
    }
    let log = Log::from_bytes("bad.csv", text.as_bytes()).unwrap();
    let refused = log.select(&names(&["a"]), &names(&["a"])).unwrap_err();
    insta::assert_snapshot!(refused.to_string());
}

#[test]
fn a_slice_keeps_every_channel() {
    let record = warned(even, |t| t.sin(), |t| t.cos());
    let part = record.slice(100..150);
    assert_eq!(part.len(), 50);
    assert_eq!(part.q[1][0], record.q[1][100]);
    assert_eq!(record.slice(990..2000).len(), 10);
}

mod any_bytes {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

        /// No input makes the reader panic, and what is accepted is sound.
        #[test]
        fn never_panic(
            cuts in prop::collection::vec((0_usize..2000, prop::collection::vec(any::<u8>(), 0..4)), 0..6),
            compress in any::<bool>(),
        ) {
            let mut bytes = if compress { gzip(&good(60)) } else { good(60).into_bytes() };
            for (at, insert) in cuts {
                let at = at % (bytes.len() + 1);
                bytes.splice(at..(at + 2).min(bytes.len()), insert);
            }
            if let Ok(log) = Log::from_bytes("x", &bytes) {
                prop_assert!(log.t.windows(2).all(|pair| pair[0] < pair[1]));
                prop_assert!(log.channels.values().all(|c| c.len() == log.len()));
                let _ = log.select(&names(&["a"]), &names(&["a"]));
            }
        }

        /// Lines in any order, of any of these tokens.
        #[test]
        fn token_soup(text in "(t|q_a|u_a|,|;|\t|#|\"|\n|\r|nan|-1e3|0\\.5| ){0,80}") {
            prop_assert!(Log::from_bytes("x", text.as_bytes()).is_err());
        }
    }
}
