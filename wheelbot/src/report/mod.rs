//! A study as one page that needs nothing else: text and tables as HTML, curves, maps and the moving
//! robot drawn by the page's own script.

use crate::studies::Study;
use cli::view;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior};
use serde_json::json;

/// The camera's distance from the robot, m.
const DISTANCE: f64 = 0.75;

/// The page.
///
/// # Errors
/// If the page cannot be put together.
pub fn page(study: &Study, command: &str) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.add_template("page.html", include_str!("page.html"))?;
    let drawn = json!({
        "charts": study.charts,
        "maps": study.maps,
        "clouds": study.clouds,
        "distance": DISTANCE,
        "motion": study.motion,
    });
    let contents = json!({
        "study": study,
        "command": command,
        "style": view::STYLE,
        "scripts": [
            view::SPACE,
            view::DRAWING,
            include_str!("robot.js"),
            view::CURVES,
            view::PLAYER,
            include_str!("maps.js"),
        ],
        "drawn": view::inside_script(drawn),
    });
    let template = environment.get_template("page.html")?;
    template.render(Serde(contents))
}

/// What is printed: findings and tables as text.
pub fn text(study: &Study) -> String {
    let mut lines = vec![study.title.clone()];
    lines.extend(study.about.iter().cloned());
    lines.push(String::new());
    for finding in &study.findings {
        let mark = match finding.holds {
            Some(true) => "holds  ",
            Some(false) => "MISSED ",
            None => "       ",
        };
        lines.push(format!("{mark}{}: {}", finding.what, finding.here));
        if finding.holds.is_some() {
            lines.push(format!("       stated: {}", finding.stated));
        }
    }
    for table in &study.tables {
        lines.push(String::new());
        lines.push(table.title.clone());
        let all: Vec<&Vec<String>> = std::iter::once(&table.header).chain(&table.rows).collect();
        let width = |column: usize| {
            let cells = all.iter().map(|row| row[column].chars().count());
            cells.max().unwrap_or(0)
        };
        for row in &all {
            let cells = row.iter().enumerate().map(|(column, cell)| {
                let padding = " ".repeat(width(column) - cell.chars().count());
                format!("{cell}{padding}")
            });
            let line: Vec<String> = cells.collect();
            lines.push(format!("  {}", line.join("  ").trim_end()));
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studies::{Chart, Finding, Table, study::Motion};

    fn study() -> Study {
        Study {
            title: "A <test> & more".into(),
            about: vec!["Of a page.".into()],
            findings: vec![
                Finding::new("Tilt", "1°", "2°", false),
                Finding::only_here("Torque", "1 N·m"),
            ],
            tables: vec![Table {
                title: "Poles".into(),
                header: vec!["".into(), "0".into()],
                rows: vec![vec!["roll".into(), "0.9".into()]],
            }],
            charts: vec![Chart {
                title: "</script> [°]".into(),
                curves: vec![("true".into(), vec![0.1234567, 1.0])],
            }],
            maps: Vec::new(),
            clouds: Vec::new(),
            motion: Motion {
                interval: 0.01,
                states: vec![[0.0; 7]; 2],
                pushes: vec![[0.0; 2]; 2],
                lifts: vec![0.0; 2],
                chassis: None,
            },
        }
    }

    #[test]
    fn what_is_printed() {
        insta::assert_snapshot!(text(&study()));
    }

    /// Nothing that a study says ends an element or asks for another file.
    #[test]
    fn the_page_holds_everything_and_asks_for_nothing() {
        let page = page(&study(), "wheelbot balance").unwrap();
        assert!(page.contains("A &lt;test&gt; &amp; more"));
        assert!(page.contains("\\u003c/script>") && page.contains("0.12346"));
        assert_eq!(page.matches("</script>").count(), 2);
        // The name of SVG's elements is no address.
        let page = page.replace("http://www.w3.org/2000/svg", "");
        for outside in ["http:", "https:", "src=", "href=", "@import", "url("] {
            assert!(!page.contains(outside), "{outside}");
        }
    }
}
