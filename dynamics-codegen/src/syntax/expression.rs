//! Expressions, units, bounds.
//!
//! Precedence is that of written mathematics, not of Rust: `^` binds tighter
//! than `*`, groups to the right, and `-x^2` is `-(x^2)`.

use super::ast::{Bounds, Expr, ExprKind, Name, Unit, UnitBase, UnitFactor};
use super::lexical::MAX_DEPTH;
use super::stream::{Parsed, Stream};
use crate::diagnostic::Diagnostic;

/// `sum := product (('+'|'-') product)*`
pub(super) fn expression(stream: &mut Stream<'_>) -> Parsed<Expr> {
    sum(stream, 0)
}

fn sum(stream: &mut Stream<'_>, depth: usize) -> Parsed<Expr> {
    let first = product(stream, depth)?;
    let mut rest = Vec::new();
    while stream.at('+') || stream.at('-') {
        let minus = stream.at('-');
        stream.skip();
        rest.push((minus, product(stream, depth)?));
    }
    Ok(chain(first, rest, ExprKind::Sum))
}

fn product(stream: &mut Stream<'_>, depth: usize) -> Parsed<Expr> {
    let first = signed(stream, depth)?;
    let mut rest = Vec::new();
    while stream.at('*') || stream.at('/') {
        let divide = stream.at('/');
        stream.skip();
        rest.push((divide, signed(stream, depth)?));
    }
    Ok(chain(first, rest, ExprKind::Product))
}

fn chain(
    first: Expr,
    rest: Vec<(bool, Expr)>,
    kind: fn(Box<Expr>, Vec<(bool, Expr)>) -> ExprKind,
) -> Expr {
    match rest.last() {
        None => first,
        Some((_, last)) => {
            let span = first.span.to(last.span);
            Expr {
                kind: kind(Box::new(first), rest),
                span,
            }
        }
    }
}

fn signed(stream: &mut Stream<'_>, depth: usize) -> Parsed<Expr> {
    check_depth(stream, depth)?;
    let start = stream.here();
    if stream.eat('-') {
        let inner = signed(stream, depth + 1)?;
        let span = start.to(inner.span);
        return Ok(Expr {
            kind: ExprKind::Negate(Box::new(inner)),
            span,
        });
    }
    if stream.eat('+') {
        return signed(stream, depth + 1);
    }
    power(stream, depth)
}

fn power(stream: &mut Stream<'_>, depth: usize) -> Parsed<Expr> {
    let mut base = atom(stream, depth)?;
    let mut members = depth;
    while stream.at_member() {
        stream.skip();
        members += 1;
        check_depth(stream, members)?;
        let name = stream.name("a component such as `x`")?;
        base = Expr {
            span: base.span.to(name.span),
            kind: ExprKind::Member(Box::new(base), name),
        };
    }
    if !stream.eat('^') {
        return Ok(base);
    }
    let exponent = signed(stream, depth + 1)?;
    let span = base.span.to(exponent.span);
    Ok(Expr {
        kind: ExprKind::Power(Box::new(base), Box::new(exponent)),
        span,
    })
}

fn atom(stream: &mut Stream<'_>, depth: usize) -> Parsed<Expr> {
    check_depth(stream, depth)?;
    if stream.input.peek(syn::LitStr) {
        let name = stream.text("a name")?;
        return Ok(Expr {
            span: name.span,
            kind: ExprKind::Name(name.text),
        });
    }
    if stream.input.peek(syn::Lit) {
        return number(stream);
    }
    if stream.input.peek(syn::token::Paren) {
        return parenthesised(stream, depth);
    }
    if stream.at('.') {
        let error = Diagnostic::error(stream.here(), "expected a number, a name or `(`")
            .help("a number begins with a digit: `0.5`");
        return Err(Box::new(error));
    }
    let name = stream.name("a number, a name or `(`")?;
    if !stream.input.peek(syn::token::Paren) {
        return Ok(Expr {
            span: name.span,
            kind: ExprKind::Name(name.text),
        });
    }
    let (arguments, close) = arguments(stream, depth)?;
    let span = name.span.to(close);
    Ok(Expr {
        kind: ExprKind::Call(name, arguments),
        span,
    })
}

fn check_depth(stream: &Stream<'_>, depth: usize) -> Parsed<()> {
    if depth <= MAX_DEPTH {
        return Ok(());
    }
    let message = format!("this expression nests more than {MAX_DEPTH} deep");
    Err(Box::new(
        Diagnostic::error(stream.here(), message).help("give the inner terms names with `let`"),
    ))
}

fn number(stream: &mut Stream<'_>) -> Parsed<Expr> {
    let here = stream.here();
    let not_a_number = |message: String| Box::new(Diagnostic::error(here, message).label("here"));
    let literal: syn::Lit = stream
        .input
        .parse()
        .map_err(|_| not_a_number("expected a number".into()))?;
    stream.passed(literal.span());
    let (digits, suffix) = match &literal {
        syn::Lit::Int(value) => (
            value.base10_digits().to_string(),
            value.suffix().to_string(),
        ),
        syn::Lit::Float(value) => (
            value.base10_digits().to_string(),
            value.suffix().to_string(),
        ),
        _ => return Err(not_a_number("expected a number, found text".into())),
    };
    if !suffix.is_empty() {
        let error = not_a_number(format!("a number has no suffix `{suffix}`"));
        return Err(Box::new(error.help(
            "numbers are in SI units; units belong behind the `:` of a declaration",
        )));
    }
    match digits.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Expr {
            kind: ExprKind::Number(value),
            span: here,
        }),
        _ => Err(not_a_number("this number is too large".into())),
    }
}

fn parenthesised(stream: &mut Stream<'_>, depth: usize) -> Parsed<Expr> {
    let here = stream.here();
    let (content, paren) = stream.parentheses()?;
    let mut inner = stream.inside(&content);
    let mut result = sum(&mut inner, depth + 1)?;
    if !inner.input.is_empty() {
        return inner.no_operator(" or `)`");
    }
    stream.passed(paren.span.close());
    result.span = here.to(stream.previous());
    Ok(result)
}

/// `(a, b, …)`, with the place of the closing bracket.
fn arguments(stream: &mut Stream<'_>, depth: usize) -> Parsed<(Vec<Expr>, crate::source::Span)> {
    let (content, paren) = stream.parentheses()?;
    let mut inner = stream.inside(&content);
    let mut arguments = Vec::new();
    while !inner.input.is_empty() {
        arguments.push(sum(&mut inner, depth + 1)?);
        if !inner.input.is_empty() && !inner.eat(',') {
            return inner.no_operator(", `,` or `)`");
        }
    }
    let close = stream.passed(paren.span.close());
    Ok((arguments, close))
}

/// `unit := factor (('*'|'/') factor)*`, `factor := '1' | name ['^' integer] | f(port) ['^' integer]`
pub(super) fn unit(stream: &mut Stream<'_>) -> Parsed<Unit> {
    let start = stream.here();
    let mut factors = vec![unit_factor(stream, 1)?];
    while stream.at('*') || stream.at('/') {
        let sign = if stream.at('/') { -1 } else { 1 };
        stream.skip();
        factors.push(unit_factor(stream, sign)?);
    }
    Ok(Unit {
        factors,
        span: start.to(stream.previous()),
    })
}

fn unit_factor(stream: &mut Stream<'_>, sign: i32) -> Parsed<UnitFactor> {
    let start = stream.here();
    if stream.input.peek(syn::LitInt) {
        let literal = number(stream)?;
        return match literal.kind {
            ExprKind::Number(1.0) => Ok(UnitFactor {
                base: UnitBase::One,
                exponent: sign,
                span: literal.span,
            }),
            _ => Err(Box::new(
                Diagnostic::error(literal.span, "a unit has no numeric factor")
                    .help("numbers are in SI units: write the factor into the value"),
            )),
        };
    }
    let name = stream.name("a unit such as `kg`, `N*m` or `1/s`")?;
    let base = if stream.input.peek(syn::token::Paren) {
        unit_of_port(stream, name)?
    } else {
        UnitBase::Named(name.text)
    };
    let exponent = if stream.eat('^') {
        unit_exponent(stream)?
    } else {
        1
    };
    Ok(UnitFactor {
        base,
        exponent: sign * exponent,
        span: start.to(stream.previous()),
    })
}

fn unit_of_port(stream: &mut Stream<'_>, function: Name) -> Parsed<UnitBase> {
    let (arguments, close) = arguments(stream, 0)?;
    match arguments.as_slice() {
        [
            Expr {
                kind: ExprKind::Name(port),
                span,
            },
        ] => Ok(UnitBase::OfPort {
            function,
            port: Name {
                text: port.clone(),
                span: *span,
            },
        }),
        _ => Err(Box::new(Diagnostic::error(
            function.span.to(close),
            format!("`{}` takes the name of one port", function.text),
        ))),
    }
}

fn unit_exponent(stream: &mut Stream<'_>) -> Parsed<i32> {
    let negative = stream.eat('-');
    let literal = number(stream)?;
    match literal.kind {
        ExprKind::Number(value) if value.fract() == 0.0 && value <= 12.0 => Ok(if negative {
            -(value as i32)
        } else {
            value as i32
        }),
        _ => Err(Box::new(Diagnostic::error(
            literal.span,
            "a unit's exponent is a small integer",
        ))),
    }
}

/// `lower..upper`, each side optional, one of them present.
pub(super) fn bounds(stream: &mut Stream<'_>) -> Parsed<Bounds> {
    let start = stream.here();
    if stream.at(';') || stream.input.is_empty() {
        return stream.unexpected("bounds such as `0..`, `-1..1` or `..5`");
    }
    let lower = if stream.at_pair('.', '.') {
        None
    } else {
        Some(expression(stream)?)
    };
    if !stream.at_pair('.', '.') {
        return stream.unexpected("bounds such as `0..`, `-1..1` or `..5`");
    }
    stream.skip();
    stream.skip();
    let ends = stream.at(';')
        || stream.at_word("prior")
        || stream.at_word("try")
        || stream.input.is_empty();
    let upper = if ends {
        None
    } else {
        Some(expression(stream)?)
    };
    let span = start.to(stream.previous());
    Ok(Bounds { lower, upper, span })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Sources;

    fn show(expr: &Expr) -> String {
        let list = |op: [&str; 2], first: &Expr, rest: &[(bool, Expr)]| {
            let tail: String = rest
                .iter()
                .map(|(b, e)| format!(" {} {}", op[usize::from(*b)], show(e)))
                .collect();
            format!("({}{tail})", show(first))
        };
        match &expr.kind {
            ExprKind::Number(value) => value.to_string(),
            ExprKind::Name(name) => name.clone(),
            ExprKind::Negate(inner) => format!("(-{})", show(inner)),
            ExprKind::Sum(first, rest) => list(["+", "-"], first, rest),
            ExprKind::Product(first, rest) => list(["*", "/"], first, rest),
            ExprKind::Power(base, exponent) => format!("({}^{})", show(base), show(exponent)),
            ExprKind::Call(name, arguments) => {
                let arguments: Vec<String> = arguments.iter().map(show).collect();
                format!("{}({})", name.text, arguments.join(", "))
            }
            ExprKind::Member(inner, name) => format!("{}.{}", show(inner), name.text),
        }
    }

    fn read(text: &str) -> String {
        let mut sources = Sources::new();
        let id = sources.add("test", text);
        let mut shown = String::new();
        let parser = |input: syn::parse::ParseStream| {
            shown = match expression(&mut Stream::new(input, id)) {
                Ok(expr) => show(&expr),
                Err(diagnostic) => diagnostic.message,
            };
            Ok(())
        };
        // What the expression leaves over is not at issue here.
        syn::parse::Parser::parse_str(parser, text).ok();
        shown
    }

    #[test]
    fn precedence_is_that_of_mathematics() {
        assert_eq!(read("a + b*c^2"), "(a + (b * (c^2)))");
        assert_eq!(read("-x^2"), "(-(x^2))");
        assert_eq!(read("m/2*dot(x)^2"), "(m / 2 * (dot(x)^2))");
        assert_eq!(read("2^-n^2"), "(2^(-(n^2)))");
        assert_eq!(read("a - (b - c)"), "(a - (b - c))");
    }

    #[test]
    fn rust_operators_mean_nothing() {
        assert_eq!(read("a * * b"), "expected a number, a name or `(`");
        assert_eq!(read("3u8"), "a number has no suffix `u8`");
    }
}
