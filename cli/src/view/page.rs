//! The page of a machine and its log.

use super::signals::{Chart, Frames};
use super::{CURVES, DRAWING, PLAYER, SPACE, STYLE, Scene, inside_script};
use crate::view::scene::POSE;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior};
use serde_json::json;

/// How far the camera is, as a share of the machine's size.
const DISTANCE: f64 = 2.2;

/// The page; `poses` are those of the scene at every frame.
///
/// # Errors
/// If it cannot be put together.
pub fn page(
    title: &str,
    scene: &Scene,
    frames: &Frames,
    poses: &[Vec<[f64; POSE]>],
    charts: &[Chart],
    command: &str,
) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.add_template("page.html", include_str!("page.html"))?;
    let drawn = json!({
        "distance": DISTANCE * scene.size,
        "scene": scene,
        "charts": charts,
        "motion": {
            "interval": frames.interval(),
            "start": frames.times[0],
            "states": poses,
        },
    });
    let contents = json!({
        "title": title,
        "command": command,
        "style": STYLE,
        "scripts": [SPACE, DRAWING, include_str!("machine.js"), CURVES, PLAYER],
        "drawn": inside_script(drawn),
    });
    let template = environment.get_template("page.html")?;
    template.render(Serde(contents))
}
