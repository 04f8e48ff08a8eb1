//! Statements about bodies: robot descriptions, frames, bodies, gravity, forces
//! at a point.

use super::ast::{BodyStatement, Expr, PointForce, RobotOption, StatementKind};
use super::expression::expression;
use super::stream::{Parsed, Stream};
use crate::diagnostic::{Diagnostic, nearest};
use crate::robot::Format;

/// What `{ … }` of a body may hold.
const BODY: [&str; 4] = ["frame", "mass", "center", "inertia"];

/// `urdf "robot.urdf" { base: floating; inputs: j1, j2; lock: j3 = 0.5; };`, the braces may be
/// left out; `mjcf` is the same of another format. Also: whether they were there.
pub(super) fn robot(stream: &mut Stream<'_>, format: Format) -> Parsed<(StatementKind, bool)> {
    let file = stream.text(match format {
        Format::Urdf => "the path of a URDF in quotes: `urdf \"robot.urdf\";`",
        Format::Mjcf => "the path of an MJCF in quotes: `mjcf \"robot.xml\";`",
    })?;
    let mut options = Vec::new();
    let braced = in_braces(stream, false, |inner| {
        let name = inner.name("an option such as `base`")?;
        inner.expect(':', "the option's name")?;
        let (mut values, mut positions) = (Vec::new(), Vec::new());
        loop {
            values.push(inner.name("a word")?);
            let position = inner.eat('=').then(|| expression(inner)).transpose()?;
            positions.push(position);
            if !inner.eat(',') {
                break;
            }
        }
        options.push(RobotOption {
            name,
            values,
            positions,
        });
        Ok(())
    })?;
    let kind = StatementKind::Robot {
        format,
        file,
        options,
    };
    Ok((kind, braced))
}

/// `frame hub = base * rotate_z(yaw) * translate(0, 0, r);`
pub(super) fn frame(stream: &mut Stream<'_>) -> Parsed<StatementKind> {
    let name = stream.name("the frame's name")?;
    stream.expect('=', "the frame's name")?;
    Ok(StatementKind::Frame {
        name,
        value: expression(stream)?,
    })
}

/// `body arm { frame: hub; mass: m; center: (0, 0, l); inertia: diag(ix, iy, iz); }`
pub(super) fn body(stream: &mut Stream<'_>) -> Parsed<StatementKind> {
    let name = stream.name("the body's name")?;
    let (mut frame, mut mass, mut center, mut inertia) = (None, None, None, None);
    in_braces(stream, true, |inner| {
        let key = inner.name("`frame`, `mass`, `center` or `inertia`")?;
        inner.expect(':', "this word")?;
        let double = match key.text.as_str() {
            "frame" => frame.replace(expression(inner)?).is_some(),
            "mass" => mass.replace(expression(inner)?).is_some(),
            "center" => center.replace(triple(inner)?).is_some(),
            "inertia" => inertia.replace(expression(inner)?).is_some(),
            other => {
                let error = Diagnostic::error(key.span, format!("a body has no `{other}`"));
                return Err(Box::new(match nearest(other, BODY) {
                    Some(near) => error.help(format!("did you mean `{near}`?")),
                    None => error.help(format!("it has: {}", BODY.join(", "))),
                }));
            }
        };
        if double {
            let message = format!("`{}` is given twice", key.text);
            return Err(Box::new(Diagnostic::error(key.span, message)));
        }
        Ok(())
    })?;
    let Some(frame) = frame else {
        let error = Diagnostic::error(name.span, format!("body `{}` has no frame", name.text));
        return Err(Box::new(error.help(
            "say where it is: `frame: translate(x, 0, 0);`, or the name of a frame",
        )));
    };
    Ok(StatementKind::Body(Box::new(BodyStatement {
        name,
        frame,
        mass,
        center,
        inertia,
    })))
}

/// `force at(tip) in hub = (fx, fy, fz)` and `torque at(tip) = (tx, ty, tz)`,
/// behind the first word.
pub(super) fn point_force(stream: &mut Stream<'_>, torque: bool) -> Parsed<StatementKind> {
    let word = stream.name("`at(frame)`")?;
    if word.text != "at" || !stream.input.peek(syn::token::Paren) {
        let error = Diagnostic::error(word.span, "expected `at(frame)`")
            .help("a torque acts on a frame: `torque at(hub) = (0, 0, m);`");
        return Err(Box::new(error));
    }
    let (content, paren) = stream.parentheses()?;
    let mut inner = stream.inside(&content);
    let at = inner.place("the name of a frame")?;
    if !inner.input.is_empty() {
        return inner.unexpected("`)`");
    }
    stream.passed(paren.span.close());
    let axes = stream
        .eat_word("in")
        .then(|| stream.place("the name of a frame"))
        .transpose()?;
    stream.expect('=', "the place")?;
    Ok(StatementKind::PointForce(Box::new(PointForce {
        at,
        axes,
        value: triple(stream)?,
        torque,
    })))
}

/// `(x, y, z)`
pub(super) fn triple(stream: &mut Stream<'_>) -> Parsed<[Expr; 3]> {
    let here = stream.here();
    if !stream.input.peek(syn::token::Paren) {
        return stream.unexpected("three components `(x, y, z)`");
    }
    let (content, paren) = stream.parentheses()?;
    let mut inner = stream.inside(&content);
    let mut parts = Vec::new();
    while !inner.input.is_empty() {
        parts.push(expression(&mut inner)?);
        if !inner.input.is_empty() && !inner.eat(',') {
            return inner.no_operator(", `,` or `)`");
        }
    }
    let span = here.to(stream.passed(paren.span.close()));
    <[Expr; 3]>::try_from(parts).map_err(|parts| {
        let message = format!("expected three components, found {}", parts.len());
        Box::new(Diagnostic::error(span, message).help("write `(x, y, z)`"))
    })
}

/// `{ key: value; key: value; … }` of a `kind` of statement, which may be left out, with the value of
/// each key. `words` are the keys as a message says them. Also: whether it was there.
pub(super) fn settings<const N: usize>(
    stream: &mut Stream<'_>,
    kind: &str,
    words: &str,
    keys: [&str; N],
) -> Parsed<([Option<Expr>; N], bool)> {
    let mut values = [const { None }; N];
    let braced = in_braces(stream, false, |inner| {
        let key = inner.name(words)?;
        inner.expect(':', "this word")?;
        let Some(place) = keys.iter().position(|known| *known == key.text) else {
            let error = format!("a {kind} has no `{}`", key.text);
            let error = Diagnostic::error(key.span, error);
            return Err(Box::new(match nearest(&key.text, keys) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help(format!("it has: {}", keys.join(", "))),
            }));
        };
        if values[place].replace(expression(inner)?).is_some() {
            let message = format!("`{}` is given twice", key.text);
            return Err(Box::new(Diagnostic::error(key.span, message)));
        }
        Ok(())
    })?;
    Ok((values, braced))
}

/// `{ entry; entry; … }`; whether it was there.
pub(super) fn in_braces(
    stream: &mut Stream<'_>,
    needed: bool,
    mut entry: impl FnMut(&mut Stream<'_>) -> Parsed<()>,
) -> Parsed<bool> {
    if !stream.input.peek(syn::token::Brace) {
        return if needed {
            stream.unexpected("`{`")
        } else {
            Ok(false)
        };
    }
    let (content, brace) = stream.braces()?;
    let mut inner = stream.inside(&content);
    while !inner.input.is_empty() {
        entry(&mut inner)?;
        if !inner.input.is_empty() {
            inner.expect(';', "this entry")?;
        }
    }
    stream.passed(brace.span.close());
    Ok(true)
}
