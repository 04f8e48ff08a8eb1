//! Recordings by libraries that share no code with the readers: `tests/tests/fixtures/logs/make.py`
//! writes them.

use super::*;

fn fixture(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/tests/fixtures/logs");
    std::fs::read(folder.join(name)).unwrap()
}

fn mapped(name: &str, map: &str) -> Log {
    let map = Map::parse("x.toml", map).unwrap();
    Log::from_bytes_with(name, &fixture(name), Some(&map)).unwrap()
}

fn nearly(found: &[f64], expected: impl Fn(usize) -> f64) {
    for (k, value) in found.iter().enumerate() {
        let expected = expected(k);
        assert!(
            (value - expected).abs() < 1e-6,
            "{k}: {value} for {expected}"
        );
    }
}

const OF_ROS: [&str; 5] = [
    "foxy.db3",
    "jazzy.db3",
    "jazzy.mcap",
    "zstd.mcap",
    "lz4.mcap",
];

/// In the order in which they were recorded late and unevenly, by the stamps of their headers.
#[test]
fn joint_states_of_every_recorder_read_as_csv_does() {
    let expected = csv(60);
    for name in OF_ROS {
        let log = Log::from_bytes(name, &fixture(name)).unwrap();
        close(&log.t, &expected.t);
        close(&log.channels["q_a"], &expected.channels["q_a"]);
        close(&log.channels["u_a"], &expected.channels["u_a"]);
        nearly(&log.channels["q_b"], |k| 2.0 * sample(k)[1]);
        // Nothing was measured of these.
        assert_eq!(log.columns(), ["t", "q_a", "q_b", "u_a"], "{name}");
        assert!(
            log.unread.contains(&"/wrench.wrench.force.x".to_owned()),
            "{name}"
        );
    }
}

/// Types of one's own are read by the definitions in the file, and topics of other rates brought to
/// the stamps of the joint states; before there were definitions, they are left out.
#[test]
fn other_topics_are_asked_for_by_the_map() {
    let map = r#"
        [columns]
        q_force = { column = "/wrench.wrench.force.z" }
        u_a = { column = "/wrench.wrench.torque.y", factor = -1 }
        u_drive = { column = "/drive.torque" }
        q_load = { column = "/drive.load.1" }
    "#;
    for name in &OF_ROS[1..] {
        let log = mapped(name, map);
        assert_eq!(log.len(), 56, "{name}");
        nearly(&log.channels["q_force"], |k| 0.03 * k as f64);
        nearly(&log.channels["u_a"], |k| -sample(k)[2]);
        nearly(&log.channels["u_drive"], |k| 0.1 * (k - k % 5) as f64);
        nearly(&log.channels["q_load"], |k| -0.01 * k as f64);
        assert!(
            said(&log).contains("topic `/drive` comes every 0.050000 s"),
            "{name}"
        );
    }
    let map = Map::parse("x.toml", map).unwrap();
    let error = Log::from_bytes_with("foxy.db3", &fixture("foxy.db3"), Some(&map)).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("`/drive.torque`, what `x.toml` says `u_drive` is")
    );
    let log = mapped(
        "foxy.db3",
        "columns.u_x = { column = \"/wrench.wrench.force.x\" }",
    );
    insta::assert_snapshot!(said(&log));
}

#[test]
fn the_map_says_whose_stamps_count() {
    let map = "time.topic = \"/wrench\"\ncolumns.u_x = { column = \"/wrench.wrench.force.x\" }";
    let log = mapped("jazzy.db3", map);
    assert!(
        said(&log).contains("brought to the stamps of `/wrench`"),
        "{}",
        said(&log)
    );
    let map = Map::parse("x.toml", "time.topic = \"/wrnch\"").unwrap();
    let error = Log::from_bytes_with("bag.db3", &fixture("jazzy.db3"), Some(&map)).unwrap_err();
    insta::assert_snapshot!(error);
}

const FLIGHT: &str = r#"
    [columns]
    q_a = { column = "arm_state.q.0" }
    dq_a = { column = "arm_state.inner.a" }
    ddq_a = { column = "arm_state.count" }
    u_a = { column = "motor.torque" }
    u_b = { column = "motor_1.torque" }
    u_c = { column = "arm_state.inner.b.1" }
"#;

/// As its format is published, and as PX4's own library writes it anew.
#[test]
fn instances_and_types_within_types_of_ulog() {
    for name in ["flight.ulg", "px4_flight.ulg"] {
        let log = mapped(name, FLIGHT);
        assert_eq!(log.len(), 59, "{name}");
        nearly(&log.t, |k| sample(k)[0]);
        nearly(&log.channels["q_a"], |k| sample(k)[1]);
        nearly(&log.channels["dq_a"], |k| sample(k)[2]);
        nearly(&log.channels["ddq_a"], |k| -(k as f64));
        nearly(&log.channels["u_a"], |k| sample(k)[2]);
        nearly(&log.channels["u_b"], |k| 2.0 * sample(k - k % 2)[2]);
        nearly(&log.channels["u_c"], |_| 255.0);
        assert!(log.unread.contains(&"arm_state.on".to_owned()));
    }
}

#[test]
fn recordings_that_break_off_are_read_up_to_there() {
    let map = Map::parse("x.toml", FLIGHT).unwrap();
    let whole = fixture("flight.ulg");
    let log = Log::from_bytes_with("x", &whole[..whole.len() - 5], Some(&map)).unwrap();
    assert!(log.len() < 60);
    insta::assert_snapshot!(log.warnings[0].to_string());
    // Garbage in front of the mark, which stands behind the messages of sample 30.
    let mark = whole
        .windows(4)
        .position(|w| w == [0x2f, 0x73, 0x13, 0x20])
        .unwrap()
        - 3;
    let damaged = [&whole[..mark], &[0xff; 50], &whole[mark..]].concat();
    let log = Log::from_bytes_with("x", &damaged, Some(&map)).unwrap();
    assert_eq!(log.len(), 59);
    insta::assert_snapshot!(log.warnings[0].to_string());
    let whole = fixture("lz4.mcap");
    let log = Log::from_bytes("x", &whole[..whole.len() - 40]).unwrap();
    insta::assert_snapshot!(said(&log));
}

/// A recorder that was stopped leaves what it wrote last in a journal.
#[test]
fn a_journal_that_is_not_read_is_told() {
    let folder = std::env::temp_dir().join(format!("journal-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("bag.db3");
    std::fs::write(&path, fixture("jazzy.db3")).unwrap();
    assert_eq!(said(&Log::read(&path).unwrap()), "");
    std::fs::write(folder.join("bag.db3-wal"), "x").unwrap();
    let warned = said(&Log::read(&path).unwrap());
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(warned.contains("its last messages stand in"), "{warned}");
    assert!(warned.contains("bag.db3-wal"), "{warned}");
}

/// Neither a field nor a message of it, but what every reader must know of.
#[test]
fn unknown_ulog_is_refused() {
    let mut bytes = fixture("flight.ulg");
    bytes[16 + 3 + 8] = 4;
    insta::assert_snapshot!(Log::from_bytes("new.ulg", &bytes).unwrap_err());
}

#[test]
fn damage_is_survived() {
    for name in [
        "foxy.db3",
        "jazzy.db3",
        "jazzy.mcap",
        "zstd.mcap",
        "lz4.mcap",
    ] {
        survives_damage(&fixture(name));
    }
    let map = Map::parse("x.toml", FLIGHT).unwrap();
    survives_damage_with(&fixture("flight.ulg"), Some(&map));
}
