//! A page as a browser lays it out.

mod picture;

pub use picture::Picture;

use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Set where a missing browser is a mistake.
const REQUIRED: &str = "DYNAMICS_BROWSER_REQUIRED";
/// Names a browser to use in place of those on the path.
const CHOICE: &str = "CHROME";
/// A folder for the pictures, to look at.
const KEEP: &str = "DYNAMICS_PICTURES";
const PROGRAMS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

const FRAME: &str = include_str!("frame.html");
const PROBE: &str = include_str!("probe.js");

/// A headless browser without a network.
pub struct Browser(PathBuf);

/// Something that is not as it should be.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Problem {
    pub rule: String,
    pub what: String,
}

/// A figure as it is seen.
#[derive(Debug, Clone, Deserialize)]
pub struct SeenFigure {
    /// Titles of ordinates and abscissas.
    pub axes: [String; 2],
    /// Curves and dots that have a size.
    pub curves: usize,
    /// Smallest letters, px.
    pub smallest: f64,
}

/// A page as it is seen.
#[derive(Debug, Clone, Deserialize)]
pub struct Seen {
    pub problems: Vec<Problem>,
    pub figures: Vec<SeenFigure>,
    /// Addresses that the page asked for.
    pub resources: Vec<String>,
    pub width: u32,
    pub height: u32,
    pub title: Option<String>,
    pub headings: Vec<String>,
    /// Rows of the table of errors.
    pub errors: Vec<Vec<String>>,
}

impl Browser {
    /// The browser of this machine; `None`, with a word, if it has none.
    ///
    /// # Panics
    /// If there is none and `DYNAMICS_BROWSER_REQUIRED` is set.
    pub fn find() -> Option<Self> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
        let installed = || {
            let programs = PROGRAMS.iter();
            let mut places = programs.flat_map(|name| folders.iter().map(move |f| f.join(name)));
            places.find(|place| place.is_file())
        };
        let chosen = std::env::var_os(CHOICE).map(PathBuf::from);
        let found = chosen.or_else(installed);
        if found.is_none() {
            assert!(
                std::env::var_os(REQUIRED).is_none(),
                "{REQUIRED} is set, but there is no browser: install chromium or set {CHOICE}"
            );
            eprintln!("layout not checked: no browser on the path, and {CHOICE} is not set");
        }
        found.map(Self)
    }

    /// Lays a page out in a window of this width and measures it.
    pub fn look(&self, page: &str, width: u32) -> Seen {
        let folder = tempfile::tempdir().unwrap();
        self.measure(folder.path(), page, width)
    }

    /// The same, and the whole page as a picture; kept under a name in the folder that
    /// `DYNAMICS_PICTURES` names.
    pub fn picture(&self, name: &str, page: &str, width: u32) -> (Seen, Picture) {
        let folder = tempfile::tempdir().unwrap();
        let seen = self.measure(folder.path(), page, width);
        let file = folder.path().join("picture.png");
        let screenshot = format!("--screenshot={}", file.display());
        self.run(folder.path(), &[&screenshot], (width, seen.height));
        let bytes = std::fs::read(&file).expect("a picture");
        if let Some(kept) = std::env::var_os(KEEP) {
            let file = Path::new(&kept).join(format!("{name}_{width}.png"));
            std::fs::write(file, &bytes).unwrap();
        }
        (seen, Picture::decode(&bytes))
    }

    fn measure(&self, folder: &Path, page: &str, width: u32) -> Seen {
        let probed = page.replace("</body>", &format!("<script>\n{PROBE}</script>\n</body>"));
        assert_ne!(probed, page, "the page ends with its body");
        std::fs::write(folder.join("page.html"), probed).unwrap();
        let frame = FRAME.replace("WIDTH", &width.to_string());
        std::fs::write(folder.join("frame.html"), frame).unwrap();
        let dump = self.run(folder, &["--dump-dom"], (width, 900));
        let start = "<script type=\"application/json\" id=\"measured\">";
        let measured = dump
            .split_once(start)
            .and_then(|(_, rest)| rest.split_once("</script>"));
        let (json, _) = measured.unwrap_or_else(|| panic!("the page did not answer:\n{dump}"));
        let seen: Seen = serde_json::from_str(json).unwrap();
        assert_eq!(seen.width, width);
        seen
    }

    /// Opens `frame.html` of a folder; what the browser prints.
    fn run(&self, folder: &Path, tasks: &[&str], (width, height): (u32, u32)) -> String {
        let profile = tempfile::tempdir().unwrap();
        let output = Command::new(&self.0)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-quic",
            ])
            .args(["--no-first-run", "--disable-background-networking"])
            .args([
                "--disable-component-update",
                "--disable-sync",
                "--hide-scrollbars",
            ])
            .args(["--disable-dev-shm-usage", "--force-device-scale-factor=1"])
            // Every name leads nowhere: whatever a page asks for fails.
            .arg("--host-resolver-rules=MAP * ~NOTFOUND")
            .arg("--virtual-time-budget=10000")
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(format!("--window-size={width},{height}"))
            .args(tasks)
            .arg(format!("file://{}", folder.join("frame.html").display()))
            .output()
            .unwrap_or_else(|error| panic!("{}: {error}", self.0.display()));
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}\n{complaint}", output.status);
        String::from_utf8(output.stdout).unwrap()
    }
}
