//! The page of a Wheelbot study in a real browser: the robot is drawn, and so is every curve.

#[allow(dead_code, reason = "the pages of `trace` have more to be looked at")]
mod browser;

use browser::Browser;
use wheelbot::report;
use wheelbot::sensing::Sensing;
use wheelbot::studies::study::{Motion, Study, charts};
use wheelbot::trial::Trial;
use wheelbot_firmware::Gains;

/// A desk's window and a telephone's, px.
const WIDTHS: [u32; 2] = [1280, 390];

#[test]
fn the_robot_and_its_curves_are_drawn() {
    let Some(browser) = Browser::find() else {
        return;
    };
    let mut sensing = Sensing::new(1).unwrap();
    let trial = Trial::new(1.0, Gains::PUBLISHED);
    let outcome = trial.run(&mut sensing).unwrap();
    let study = Study {
        title: "A second of balancing".into(),
        about: Vec::new(),
        findings: Vec::new(),
        tables: Vec::new(),
        charts: charts(&outcome),
        maps: Vec::new(),
        clouds: Vec::new(),
        motion: Motion::of(&outcome.rows),
    };
    let page = report::page(&study, "wheelbot balance").unwrap();
    for width in WIDTHS {
        let (seen, picture) = browser.picture("wheelbot", &page, width);
        assert!(seen.resources.is_empty(), "{:?}", seen.resources);
        // Titles of these charts stand in their captions, with units.
        let laid_out = seen
            .problems
            .iter()
            .filter(|problem| problem.rule != "axis without unit");
        assert_eq!(laid_out.count(), 0, "{width} px: {:?}", seen.problems);
        assert_eq!(seen.figures.len(), study.charts.len());
        assert!(seen.figures.iter().all(|figure| figure.curves >= 2));
        // Wheels, chassis and floor: without the script the view is empty.
        assert!(picture.colours(0..picture.height / 2) > 20, "{width} px");
    }
}
