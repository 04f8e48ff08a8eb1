//! The statements of a part as one use reads them: with the use's name in front of what the part
//! defines, and with the arguments in place of the ports.

use crate::model::component_names;
use crate::source::Span;
use crate::syntax::{
    Bounds, ContactStatement, Expr, ExprKind, Name, PartStatement, PointForce, Prior,
    SensorStatement, Statement, StatementKind,
};
use std::collections::{BTreeMap, BTreeSet};

/// How names are read in the model, or in one use of a part.
pub(super) struct Scope {
    /// In front of what is defined here.
    prefix: String,
    /// What is defined here, for others to name.
    own: BTreeSet<String>,
    /// What ports stand for.
    ports: BTreeMap<String, String>,
    /// The uses that are written here.
    uses: BTreeSet<String>,
    /// The uses in the model itself.
    top: BTreeSet<String>,
    reading: usize,
}

/// The path that an expression is: `left`, `left.knee.q`.
pub(super) fn path(expr: &Expr) -> Option<String> {
    match &expr.kind {
        ExprKind::Name(name) => Some(name.clone()),
        ExprKind::Member(inner, member) => Some(format!("{}.{}", path(inner)?, member.text)),
        _ => None,
    }
}

/// What a statement defines.
pub(super) fn declared(kind: &StatementKind) -> Option<&Name> {
    match kind {
        StatementKind::Coordinate { name, .. }
        | StatementKind::Input { name, .. }
        | StatementKind::State { name, .. }
        | StatementKind::Parameter { name, .. }
        | StatementKind::Constant { name, .. }
        | StatementKind::Let { name, .. }
        | StatementKind::Constraint { name, .. }
        | StatementKind::Frame { name, .. } => Some(name),
        StatementKind::Contact(contact) => Some(&contact.name),
        StatementKind::Sensor(sensor) => Some(&sensor.name),
        StatementKind::Body(body) => Some(&body.name),
        StatementKind::Use(used) => Some(&used.name),
        _ => None,
    }
}

impl Scope {
    /// The model itself: names stay as they are, but for paths.
    pub fn model(uses: BTreeSet<String>) -> Self {
        Self {
            prefix: String::new(),
            own: BTreeSet::new(),
            ports: BTreeMap::new(),
            top: uses.clone(),
            uses,
            reading: 0,
        }
    }

    /// A part, used under a name.
    pub fn of_part(
        part: &PartStatement,
        name: &str,
        reading: usize,
        top: &BTreeSet<String>,
    ) -> Self {
        let own = part.statements.iter().filter_map(|s| declared(&s.kind));
        let own = own.chain(&part.ports).chain(&part.unreadable);
        let components = part.statements.iter().flat_map(|s| match &s.kind {
            StatementKind::Sensor(sensor) => component_names(sensor),
            _ => Vec::new(),
        });
        Self {
            prefix: format!("{name}_"),
            own: own
                .map(|name| name.text.clone())
                .chain(components)
                .collect(),
            ports: BTreeMap::new(),
            uses: super::names_of_uses(&part.statements),
            top: top.clone(),
            reading,
        }
    }

    pub fn is_model(&self) -> bool {
        self.prefix.is_empty()
    }

    /// Lets a port stand for something that has a name.
    pub fn bind(&mut self, port: &str, name: String) {
        self.ports.insert(port.to_string(), name);
    }

    /// The same place, as this use reads it.
    pub fn span(&self, span: Span) -> Span {
        Span {
            source: span.source.read_as(self.reading),
            ..span
        }
    }

    /// About how many bytes of a model a place is with its names written out.
    pub fn cost(&self, span: Span) -> usize {
        // A name is two bytes at least, with what separates it from the next.
        (span.end - span.start) * (2 + self.prefix.len()) / 2
    }

    /// What a name that is defined here is called in the model.
    pub fn declare(&self, name: &Name) -> Name {
        Name {
            text: format!("{}{}", self.prefix, name.text),
            span: self.span(name.span),
        }
    }

    /// What the model calls what is named here.
    pub fn refer(&self, name: &str) -> String {
        if let Some((head, rest)) = name.split_once('.') {
            let rest = rest.replace('.', "_");
            if self.uses.contains(head) {
                return format!("{}{head}_{rest}", self.prefix);
            }
            if let Some(given) = self.ports.get(head) {
                return format!("{given}_{rest}");
            }
            if self.top.contains(head) {
                return format!("{head}_{rest}");
            }
        }
        match self.ports.get(name) {
            Some(given) => given.clone(),
            None if self.own.contains(name) => format!("{}{name}", self.prefix),
            None => name.to_string(),
        }
    }

    fn name(&self, name: &Name) -> Name {
        Name {
            text: self.refer(&name.text),
            span: self.span(name.span),
        }
    }

    /// An expression as it is read here.
    pub fn expr(&self, expr: &Expr) -> Expr {
        let chain = |first: &Expr, rest: &[(bool, Expr)]| {
            let rest = rest.iter().map(|(other, expr)| (*other, self.expr(expr)));
            (Box::new(self.expr(first)), rest.collect())
        };
        let boxed = |expr: &Expr| Box::new(self.expr(expr));
        let kind = match &expr.kind {
            ExprKind::Number(value) => ExprKind::Number(*value),
            ExprKind::Name(name) => ExprKind::Name(self.refer(name)),
            ExprKind::Negate(inner) => ExprKind::Negate(boxed(inner)),
            ExprKind::Sum(first, rest) => {
                let (first, rest) = chain(first, rest);
                ExprKind::Sum(first, rest)
            }
            ExprKind::Product(first, rest) => {
                let (first, rest) = chain(first, rest);
                ExprKind::Product(first, rest)
            }
            ExprKind::Power(base, exponent) => ExprKind::Power(boxed(base), boxed(exponent)),
            ExprKind::Call(function, arguments) => {
                let function = Name {
                    text: function.text.clone(),
                    span: self.span(function.span),
                };
                ExprKind::Call(function, arguments.iter().map(|a| self.expr(a)).collect())
            }
            ExprKind::Member(inner, member) => match path(expr) {
                Some(path) if self.leads_on(&path) => ExprKind::Name(self.refer(&path)),
                _ => {
                    let member = Name {
                        text: member.text.clone(),
                        span: self.span(member.span),
                    };
                    ExprKind::Member(boxed(inner), member)
                }
            },
        };
        Expr {
            kind,
            span: self.span(expr.span),
        }
    }

    /// Whether a path goes through a use, directly or by a port.
    fn leads_on(&self, path: &str) -> bool {
        let head = path.split('.').next().unwrap_or(path);
        self.uses.contains(head) || self.ports.contains_key(head) || self.top.contains(head)
    }

    fn option(&self, expr: &Option<Expr>) -> Option<Expr> {
        expr.as_ref().map(|expr| self.expr(expr))
    }

    fn triple(&self, triple: &[Expr; 3]) -> [Expr; 3] {
        [0, 1, 2].map(|axis| self.expr(&triple[axis]))
    }

    /// A statement as it is read here. Parts and uses are not for here.
    pub fn statement(&self, statement: &Statement) -> Statement {
        let mut kind = statement.kind.clone();
        self.rename(&mut kind);
        Statement {
            doc: statement.doc.clone(),
            span: self.span(statement.span),
            kind,
        }
    }

    fn rename(&self, kind: &mut StatementKind) {
        match kind {
            StatementKind::Coordinate { name, unit } => {
                *name = self.declare(name);
                self.place_unit(unit);
            }
            StatementKind::Input { name, unit } => {
                *name = self.declare(&self.whole(name));
                self.place_unit(unit);
            }
            StatementKind::State {
                name,
                unit,
                initial,
            } => {
                *name = self.declare(name);
                self.place_unit(unit);
                *initial = self.option(initial);
            }
            StatementKind::Parameter { .. } => self.rename_parameter(kind),
            StatementKind::Constant { name, unit, value } => {
                *name = self.declare(name);
                self.place_unit(unit);
                *value = self.expr(value);
            }
            StatementKind::Let { name, value }
            | StatementKind::Output { name, value }
            | StatementKind::Frame { name, value } => {
                *name = self.declare(name);
                *value = self.expr(value);
            }
            StatementKind::Measured { name, value }
            | StatementKind::Mounted { name, value }
            | StatementKind::Channel { name, value }
            | StatementKind::Rate { name, value }
            | StatementKind::Force { on: name, value } => {
                *name = self.name(name);
                *value = self.expr(value);
            }
            StatementKind::Kinetic(value)
            | StatementKind::Potential(value)
            | StatementKind::Dissipation(value) => *value = self.expr(value),
            StatementKind::Constraint {
                name,
                when,
                left,
                right,
            } => {
                *name = self.declare(name);
                *when = self.option(when);
                (*left, *right) = (self.expr(left), self.expr(right));
            }
            StatementKind::Sensor(sensor) => self.rename_sensor(sensor),
            StatementKind::Contact(contact) => self.rename_contact(contact),
            StatementKind::Gravity(components) => **components = self.triple(components),
            StatementKind::PointForce(force) => self.rename_point_force(force),
            StatementKind::Body(body) => {
                body.name = self.declare(&body.name);
                body.frame = self.expr(&body.frame);
                body.mass = self.option(&body.mass);
                body.center = body.center.as_ref().map(|center| self.triple(center));
                body.inertia = self.option(&body.inertia);
            }
            StatementKind::Effect {
                template,
                on,
                values,
            } => {
                template.span = self.span(template.span);
                on.iter_mut().for_each(|place| *place = self.name(place));
                for (name, value) in values {
                    name.span = self.span(name.span);
                    *value = self.expr(value);
                }
            }
            StatementKind::Term { neighbours, .. } => {
                *neighbours = neighbours.map(|span| self.span(span));
            }
            StatementKind::Table(_)
            | StatementKind::Robot { .. }
            | StatementKind::Part(_)
            | StatementKind::Use(_) => {}
        }
    }

    /// What a use has of an input is no name to declare one by: it is said by the builder that
    /// there is one already.
    fn whole(&self, name: &Name) -> Name {
        Name {
            text: name.text.replace('.', "_"),
            span: name.span,
        }
    }

    fn place_unit(&self, unit: &mut Option<crate::syntax::Unit>) {
        if let Some(unit) = unit {
            unit.span = self.span(unit.span);
            for factor in &mut unit.factors {
                factor.span = self.span(factor.span);
            }
        }
    }

    fn rename_parameter(&self, kind: &mut StatementKind) {
        let StatementKind::Parameter {
            name,
            unit,
            nominal,
            bounds,
            prior,
            tries,
        } = kind
        else {
            return;
        };
        *name = self.declare(name);
        self.place_unit(unit);
        *nominal = self.option(nominal);
        *bounds = bounds.as_ref().map(|bounds| Bounds {
            lower: self.option(&bounds.lower),
            upper: self.option(&bounds.upper),
            span: self.span(bounds.span),
        });
        *prior = prior.as_ref().map(|prior| {
            Box::new(Prior {
                mean: self.expr(&prior.mean),
                sd: self.expr(&prior.sd),
            })
        });
        *tries = self.option(tries);
    }

    fn rename_sensor(&self, sensor: &mut SensorStatement) {
        sensor.name = self.declare(&sensor.name);
        self.place_unit(&mut sensor.unit);
        sensor.value = self.expr(&sensor.value);
        for setting in [&mut sensor.noise, &mut sensor.resolution, &mut sensor.rate] {
            *setting = self.option(setting);
        }
    }

    fn rename_contact(&self, contact: &mut ContactStatement) {
        contact.name = self.declare(&contact.name);
        contact.shape = self.expr(&contact.shape);
        contact.plane = self.expr(&contact.plane);
        contact.friction = self.option(&contact.friction);
        contact.restitution = self.option(&contact.restitution);
    }

    fn rename_point_force(&self, force: &mut PointForce) {
        force.at = self.name(&force.at);
        force.axes = force.axes.as_ref().map(|axes| self.name(axes));
        force.value = self.triple(&force.value);
    }
}
