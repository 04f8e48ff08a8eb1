//! What the user can mend: the place, what was expected, how to mend it.

use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Renderer, Snippet};
use dynamics_codegen::Report;
use std::fmt;
use std::ops::Range;
use std::path::Path;

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
    pub fn unreadable(path: &Path, error: &std::io::Error) -> Self {
        Self::new(format!("cannot read `{}`: {error}", path.display()))
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

impl Plain {
    fn render(&self, level: Level<'static>, colours: bool) -> String {
        let title = level.primary_title(self.message.as_str());
        let mut groups = vec![match &self.place {
            Some(place) => title.element(place.snippet()),
            None => Group::with_title(title),
        }];
        for help in &self.help {
            groups.push(Group::with_title(
                Level::HELP.secondary_title(help.as_str()),
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
            annotation.label(self.label.as_str())
        };
        Snippet::source(self.text.as_str())
            .path(self.file.as_str())
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
