//! `dynamics view`: a page of a log.

use crate::support::{refuse, succeed};
use serde_json::Value;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// Two links in the plane, each hanging from its joint, and a foot that a floor may touch.
const MACHINE: &str = "model legs;
coordinate a: rad;
coordinate b: rad;
input a: N*m;
frame knee = rotate_y(a) * translate(0, 0, -0.4);
frame foot = knee * rotate_y(b) * translate(0, 0, -0.3);
frame floor = translate(0, 0, -0.7);
body thigh { frame: knee; mass: 2; inertia: diag(0.01, 0.01, 0.002); }
body shin { frame: foot; mass: 1; inertia: diag(0.005, 0.005, 0.001); }
force a = input(a);
gravity (0, 0, -9.81);
contact heel: sphere(foot, 0.02) on plane_z(floor);
";

/// Sixty rows, the last twenty twice as far apart: the hip turns evenly up to a right angle, the knee stays
/// straight, and a gauge shows ten times the time. The input is not there.
fn log() -> String {
    let time = |k: u32| f64::from(k.min(40)) * 0.01 + f64::from(k.saturating_sub(40)) * 0.02;
    let end = time(59);
    let row = |k| {
        let t = time(k);
        format!("{t},{},0,{}\n", FRAC_PI_2 * t / end, 10.0 * t)
    };
    let rows: String = (0..60).map(row).collect();
    format!("t,q_a,q_b,gauge\n{rows}")
}

fn written(folder: &Path) -> [String; 3] {
    let files = [("legs.model", MACHINE.to_string()), ("log.csv", log())];
    let path = |name: &str| folder.join(name).to_str().unwrap().to_string();
    for (name, text) in files {
        std::fs::write(path(name), text).unwrap();
    }
    ["legs.model", "log.csv", "page.html"].map(path)
}

/// What a page draws.
fn drawn(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"drawn\">").unwrap();
    let (json, _) = rest.split_once("</script>").unwrap();
    serde_json::from_str(json).unwrap()
}

#[test]
fn bodies_are_where_the_log_says() {
    let folder = tempfile::tempdir().unwrap();
    let [model, log, page] = written(folder.path());
    succeed(&["view", &model, &log, "--out", &page], "");
    let page = std::fs::read_to_string(&page).unwrap();
    let drawn = drawn(&page);
    let scene = &drawn["scene"];
    let names: Vec<&str> = (scene["bodies"].as_array().unwrap().iter())
        .map(|body| body["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["thigh", "shin"]);
    assert_eq!(scene["contacts"][0]["shape"], "sphere");
    // The last frame: both links along −x.
    let states = drawn["motion"]["states"].as_array().unwrap();
    assert_eq!(states.len(), 60);
    let shin = scene["bodies"][1]["pose"].as_u64().unwrap() as usize;
    let place: Vec<f64> = (0..3)
        .map(|k| states[59][shin][k].as_f64().unwrap())
        .collect();
    for (found, expected) in place.iter().zip([-0.7, 0.0, 0.0]) {
        assert!((found - expected).abs() < 1e-4, "{place:?}");
    }
    let charts = drawn["charts"].as_array().unwrap();
    let titles: Vec<&str> = charts
        .iter()
        .map(|chart| chart["title"].as_str().unwrap())
        .collect();
    assert_eq!(titles, ["position [rad]", "gauge"]);
    // Frames are evenly apart, rows are not.
    let interval = drawn["motion"]["interval"].as_f64().unwrap();
    let shown = charts[1]["curves"][0][1][50].as_f64().unwrap();
    assert!((shown - 10.0 * 50.0 * interval).abs() < 3e-3, "{shown}");
    // It works offline.
    let page = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn what_cannot_be_seen_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let [model, log, page] = written(folder.path());
    let bare = folder.path().join("bare.model");
    let text = "model bare; coordinate x: m; parameter m: kg = 1; kinetic m/2*dot(x)^2;";
    std::fs::write(&bare, text).unwrap();
    let short = folder.path().join("short.csv");
    let rows: String = (0..60)
        .map(|k| format!("{},{k}\n", 0.01 * f64::from(k)))
        .collect();
    std::fs::write(&short, format!("t,q_a\n{rows}")).unwrap();
    let [bare, short] = [bare, short].map(|path| path.to_str().unwrap().to_string());
    let said = refuse(&["view", &bare, &log, "--out", &page], "");
    assert!(said.contains("has no bodies"), "{said}");
    let said = refuse(&["view", &model, &short, "--out", &page], "");
    assert!(said.contains("q_b"), "{said}");
    assert!(!Path::new(&page).exists());
}
