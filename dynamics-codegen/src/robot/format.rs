//! The formats of robot descriptions, and how messages speak of them.

/// A format of robot descriptions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// The Unified Robot Description Format, `<robot>`.
    Urdf,
    /// MuJoCo's own, `<mujoco>`.
    Mjcf,
}

impl Format {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Urdf, Self::Mjcf];

    /// The format of a text, by its outermost element; `None` if it is no XML, and so no
    /// description. What is neither is read as a URDF, whose reader says what it found.
    ///
    /// ```
    /// use dynamics_codegen::robot::Format;
    ///
    /// assert_eq!(Format::of("<robot name=\"arm\"/>"), Some(Format::Urdf));
    /// assert_eq!(Format::of("<!-- an arm -->\n<mujoco/>"), Some(Format::Mjcf));
    /// assert_eq!(Format::of("model arm;"), None);
    /// ```
    pub fn of(text: &str) -> Option<Self> {
        let rest = text.trim_start_matches('\u{feff}').trim_start();
        rest.starts_with('<').then(|| {
            let name = &rest[outermost(rest)..];
            match name.strip_prefix("<mujoco") {
                Some(behind) if !behind.starts_with(is_of_name) => Self::Mjcf,
                _ => Self::Urdf,
            }
        })
    }

    /// The word of the statement that takes such a description as the base of a model.
    pub fn word(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            Self::Mjcf => "mjcf",
        }
    }

    /// The name of the outermost element.
    pub fn root(self) -> &'static str {
        match self {
            Self::Urdf => "robot",
            Self::Mjcf => "mujoco",
        }
    }

    /// "a URDF".
    pub(crate) fn one(self) -> &'static str {
        match self {
            Self::Urdf => "a URDF",
            Self::Mjcf => "an MJCF",
        }
    }

    /// What the format calls a body.
    pub(crate) fn body(self) -> &'static str {
        match self {
            Self::Urdf => "link",
            Self::Mjcf => "body",
        }
    }

    /// How the whole is written.
    pub(crate) fn shape(self) -> &'static str {
        match self {
            Self::Urdf => "a URDF is one <robot name=\"…\"> … </robot>",
            Self::Mjcf => "an MJCF is one <mujoco> … </mujoco>",
        }
    }

    /// The deepest nesting of elements; a URDF needs 5, an MJCF one more for every body.
    pub(crate) fn depth(self) -> u32 {
        match self {
            Self::Urdf => 64,
            Self::Mjcf => 1024,
        }
    }

    /// What to do about deeper ones.
    pub(crate) fn nesting(self) -> &'static str {
        match self {
            Self::Urdf => {
                "links and joints stand side by side in <robot>; only <parent> and <child> connect them"
            }
            Self::Mjcf => "bodies stand in the body that carries them, and nothing else is nested",
        }
    }

    /// How a joint gets something to move.
    pub(crate) fn mend_of_immobile(self) -> &'static str {
        match self {
            Self::Urdf => "give a link beyond it an <inertial>, or make the joint type=\"fixed\"",
            Self::Mjcf => {
                "give a body beyond it an <inertial> or a <geom> that has mass, or leave the joint out"
            }
        }
    }
}

/// Where the outermost element begins: behind declarations and comments.
fn outermost(text: &str) -> usize {
    let mut at = 0;
    loop {
        let rest = text[at..].trim_start();
        let start = text.len() - rest.len();
        let end = if rest.starts_with("<!--") {
            rest.find("-->").map(|end| end + 3)
        } else if rest.starts_with("<?") || rest.starts_with("<!") {
            rest.find('>').map(|end| end + 1)
        } else {
            None
        };
        match end {
            Some(end) => at = start + end,
            None => return start,
        }
    }
}

/// What may stand in the middle of an element's name.
fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || "_-.:".contains(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outermost_element_tells() {
        let mjcf = [
            "<mujoco>",
            "\u{feff}<?xml version=\"1.0\"?>\n<!-- <robot> -->\n<!--\n--> <mujoco model=\"a\">",
            "<mujoco/>",
        ];
        for text in mjcf {
            assert_eq!(Format::of(text), Some(Format::Mjcf), "{text}");
        }
        let urdf = [
            "<robot><mujoco/></robot>",
            "<mujocoinclude/>",
            "<",
            "<!-- <mujoco>",
            "<!--",
            "<?",
        ];
        for text in urdf {
            assert_eq!(Format::of(text), Some(Format::Urdf), "{text}");
        }
        for text in ["", "model m;", "mujoco"] {
            assert_eq!(Format::of(text), None, "{text}");
        }
    }
}
