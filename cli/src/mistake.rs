//! What the user can mend: the place, what was expected, how to mend it.

use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Renderer, Snippet};
use dynamics_codegen::Report;
use dynamics_codegen::diagnostic::{nearest, visible, visible_source};
use std::io::{self, ErrorKind};
use std::ops::Range;
use std::path::Path;
use std::{fmt, fs};

/// Bad input. Ends the program with exit code 2.
#[derive(Debug, Clone)]
pub struct Mistake(Box<Kind>);

#[derive(Debug, Clone)]
enum Kind {
    /// Found by the model's compiler.
    Model(Report),
    /// Found by the command line.
    Plain(Plain),
}

#[derive(Debug, Clone)]
struct Plain {
    message: String,
    place: Option<Place>,
    help: Vec<String>,
}

/// A place in a text of the user's.
#[derive(Debug, Clone)]
pub struct Place {
    /// What the user calls the text.
    pub file: String,
    /// The number of the first line of `text` in the file, from one.
    pub first_line: usize,
    /// The text, or the lines of it that matter.
    pub text: String,
    /// The bytes of `text` that are meant.
    pub range: Range<usize>,
    /// A word about them; may be empty.
    pub label: String,
}

impl Mistake {
    /// A mistake that has no place in a text.
    pub fn new(message: impl Into<String>) -> Self {
        Self::plain(message.into(), None)
    }

    /// A mistake at a place.
    pub fn at(place: Place, message: impl Into<String>) -> Self {
        Self::plain(message.into(), Some(place))
    }

    /// A file that the system would not let us read.
    pub fn unreadable(path: &Path, error: &io::Error) -> Self {
        let because =
            |reason: &str| Self::new(format!("cannot read `{}`: {reason}", path.display()));
        match error.kind() {
            ErrorKind::NotFound => because("there is no such file").help(neighbour(path)),
            ErrorKind::IsADirectory => because("it is a folder").help("name a file in it"),
            ErrorKind::NotADirectory => because("it is not a folder").help("check the path"),
            ErrorKind::InvalidData => because("it is not UTF-8 text").help("save it as UTF-8"),
            ErrorKind::PermissionDenied => {
                because("permission denied").help("change its access rights, or copy it")
            }
            ErrorKind::FileTooLarge => {
                because(&error.to_string()).help("is it the right file? if so, shorten it")
            }
            ErrorKind::InvalidInput => because(&error.to_string())
                .help("what comes out of a pipe or a device can be saved to a file first"),
            _ => because(&error.to_string()),
        }
    }

    fn plain(message: String, place: Option<Place>) -> Self {
        Self(Box::new(Kind::Plain(Plain {
            message,
            place,
            help: Vec::new(),
        })))
    }

    /// Says how to mend it.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        if let Kind::Plain(plain) = self.0.as_mut() {
            plain.help.push(text.into());
        }
        self
    }

    /// As text for a terminal, with or without colours.
    pub fn render(&self, colours: bool) -> String {
        match self.0.as_ref() {
            Kind::Model(report) if colours => report.render_styled(),
            Kind::Model(report) => report.render(),
            Kind::Plain(plain) => plain.render(Level::ERROR, colours),
        }
    }

    /// As text, called a warning: for what does not stop the work.
    pub fn render_as_warning(&self, colours: bool) -> String {
        match self.0.as_ref() {
            Kind::Plain(plain) => plain.render(Level::WARNING, colours),
            Kind::Model(_) => self.render(colours),
        }
    }
}

/// What may have been meant by a path that leads nowhere.
fn neighbour(path: &Path) -> String {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let Ok(entries) = fs::read_dir(folder) else {
        return format!("there is no folder `{}` either", folder.display());
    };
    let stem = |path: &Path| {
        path.file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let mut stems: Vec<String> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|found| found.extension() == path.extension())
        .map(|found| stem(&found))
        .collect();
    stems.sort();
    match nearest(&stem(path), stems.iter().map(String::as_str)) {
        Some(near) => {
            let mut found = path.with_file_name(near);
            found.set_extension(path.extension().unwrap_or_default());
            format!("did you mean `{}`?", found.display())
        }
        None => "check the path".to_string(),
    }
}

impl Plain {
    fn render(&self, level: Level<'static>, colours: bool) -> String {
        let title = level.primary_title(visible(&self.message));
        let mut groups = vec![match &self.place {
            Some(place) => title.element(place.snippet()),
            None => Group::with_title(title),
        }];
        for help in &self.help {
            groups.push(Group::with_title(
                Level::HELP.secondary_title(visible(help)),
            ));
        }
        let renderer = if colours {
            Renderer::styled()
        } else {
            Renderer::plain()
        };
        renderer.render(&groups)
    }
}

impl Place {
    fn snippet(&self) -> Snippet<'_, Annotation<'_>> {
        let annotation = AnnotationKind::Primary.span(self.range.clone());
        let annotation = if self.label.is_empty() {
            annotation
        } else {
            annotation.label(visible(&self.label))
        };
        Snippet::source(visible_source(&self.text))
            .path(visible(&self.file))
            .line_start(self.first_line)
            .annotation(annotation)
    }
}

impl From<Report> for Mistake {
    fn from(report: Report) -> Self {
        Self(Box::new(Kind::Model(report)))
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Mistake {}
