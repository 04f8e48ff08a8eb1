//! Sensors: what a log shows beside the coordinates, with noise, resolution and rate.

use super::builder::{Builder, MAX_SIZE};
use super::names::VECTORS;
use super::quantity::{Measure, Quantity};
use super::sensed::component_names;
use super::{Model, Reading, Sensor};
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::{Binary, ExprId, SymbolId};
use crate::source::Span;
use crate::syntax::{Expr, ExprKind, Name, SensorStatement, Statement, StatementKind};

/// The functions that only a sensor can read, of frames.
pub(super) const MOMENTARY_VECTORS: [&str; 4] = [
    "acceleration",
    "angular_acceleration",
    "gyroscope",
    "accelerometer",
];
/// The angle of one frame against another about an axis of the second.
pub(super) const ENCODERS: [&str; 3] = ["encoder_x", "encoder_y", "encoder_z"];

impl Model {
    /// The symbols of the accelerations that sensors read; none if the model has no sensor.
    pub fn sensed_accelerations(&self) -> &[SymbolId] {
        &self.accelerations
    }

    /// Time derivatives along the true motion: as the seeds at `a = 0`, but with
    /// accelerations as they are.
    fn true_time_seeds(&mut self) -> Vec<(SymbolId, ExprId)> {
        let mut seeds = self.time_seeds();
        for (coordinate, &a) in self.coordinates.iter().zip(&self.accelerations) {
            seeds.push((coordinate.velocity, self.graph.var(a)));
        }
        for index in 0..self.kinematics.len() {
            let super::Kinematic {
                symbol,
                frame,
                reading,
            } = self.kinematics[index];
            let rate = match reading {
                Reading::Velocity(i) => Reading::Acceleration(i),
                Reading::AngularVelocity(i) => Reading::AngularAcceleration(i),
                _ => continue,
            };
            seeds.retain(|(seed, _)| *seed != symbol);
            let rate = self.reading(frame, rate);
            seeds.push((symbol, rate));
        }
        seeds
    }

    /// Whether an expression contains a velocity or an acceleration.
    pub(super) fn is_momentary(&self, expr: ExprId) -> bool {
        self.contains_velocity(expr) || self.contains_acceleration(expr)
    }

    /// Whether an expression contains an acceleration.
    fn contains_acceleration(&self, expr: ExprId) -> bool {
        let readings = self.kinematics.iter();
        let of_frames = readings
            .filter(|k| k.reading.is_acceleration())
            .map(|k| k.symbol);
        let mut all = self.accelerations.iter().copied().chain(of_frames);
        all.any(|symbol| self.graph.depends_on(&[expr], symbol))
    }
}

impl Builder<'_> {
    /// The sensors, when everything else is known: gravity, and what effects add.
    pub(super) fn lower_sensors(&mut self, statements: &[&Statement]) {
        let is_sensor = |s: &&&Statement| matches!(s.kind, StatementKind::Sensor(_));
        let sensors = statements.iter().filter(is_sensor);
        if self.too_large || sensors.clone().next().is_none() {
            return;
        }
        for statement in sensors {
            if let StatementKind::Sensor(sensor) = &statement.kind {
                self.lower_sensor(sensor, &statement.doc);
            }
        }
    }

    /// What a sensor shows, by the names of its columns.
    pub(super) fn sensor_components(
        &mut self,
        sensor: &SensorStatement,
    ) -> Option<Vec<(String, Quantity)>> {
        if self.model.accelerations.is_empty() {
            let coordinates = self.model.coordinates.iter();
            let names: Vec<String> = coordinates.map(|c| format!("ddq_{}", c.name)).collect();
            let symbols = names.into_iter().map(|name| self.model.graph.symbol(name));
            self.model.accelerations = symbols.collect();
        }
        self.in_sensor = true;
        let shown = self.shown_by(&sensor.value);
        self.in_sensor = false;
        Some(component_names(sensor).into_iter().zip(shown?).collect())
    }

    fn shown_by(&mut self, value: &Expr) -> Option<Vec<Quantity>> {
        match &value.kind {
            ExprKind::Call(function, arguments)
                if VECTORS.contains(&function.text.as_str())
                    || MOMENTARY_VECTORS.contains(&function.text.as_str()) =>
            {
                let vector = self.vector(function, arguments, value.span)?;
                (0..3).map(|component| vector(self, component)).collect()
            }
            _ => Some(vec![self.lower(value)?]),
        }
    }

    fn lower_sensor(&mut self, sensor: &SensorStatement, doc: &str) -> Option<()> {
        let SensorStatement { name, value, .. } = sensor;
        let components = self.sensor_components(sensor)?;
        let declared = match &sensor.unit {
            Some(unit) => Some(self.dimension(unit)?),
            None => None,
        };
        let noise = self.setting(sensor.noise.as_ref(), "noise", components[0].1.measure)?;
        let resolution = self.setting(
            sensor.resolution.as_ref(),
            "resolution",
            components[0].1.measure,
        )?;
        let per_second = Measure::Known(Dimension::ONE / Dimension::TIME);
        let rate = self.setting(sensor.rate.as_ref(), "rate", per_second)?;
        for (text, quantity) in components {
            if let Some(dimension) = declared {
                self.expect_dimension(quantity, dimension, value.span, "what the sensor shows")?;
            }
            self.refuse_loads(quantity.expr, value.span)?;
            self.refuse_namesakes(&text, name.span)?;
            let (value, lead) = self.read_of(&text, quantity.expr);
            self.model.sensors.push(Sensor {
                name: text,
                value,
                lead,
                dimension: declared.or(quantity.measure.known()),
                noise: noise.unwrap_or(0.0),
                resolution,
                rate,
                doc: doc.to_string(),
            });
        }
        if self.model.sensors.len() > MAX_SIZE {
            let message = format!("the model has more than {MAX_SIZE} sensors");
            return self.report(Diagnostic::error(name.span, message));
        }
        Some(())
    }

    /// A positive number that a sensor is described by; `Some(None)` where it is not stated.
    fn setting(&mut self, value: Option<&Expr>, word: &str, unit: Measure) -> Option<Option<f64>> {
        let Some(expr) = value else {
            return Some(None);
        };
        let quantity = self.lower(expr)?;
        if let Measure::Known(dimension) = unit {
            let role = format!("the `{word}` of this sensor");
            self.expect_dimension(quantity, dimension, expr.span, &role)?;
        }
        match self.model.graph.as_constant(quantity.expr) {
            Some(number) if number > 0.0 => Some(Some(number)),
            Some(_) => {
                let message = format!("the `{word}` of a sensor is above zero");
                let help = format!("leave `{word}` out where there is none to speak of");
                self.report(Diagnostic::error(expr.span, message).help(help))
            }
            None => {
                let message = format!("the `{word}` of a sensor is a number");
                let help = "it may contain constants, no parameters";
                self.report(Diagnostic::error(expr.span, message).help(help))
            }
        }
    }

    /// A log has one column of a name.
    fn refuse_namesakes(&mut self, name: &str, span: Span) -> Option<()> {
        let is = |group: &str, known: &str| {
            let rest = name.strip_prefix(group).and_then(|r| r.strip_prefix('_'));
            rest == Some(known)
        };
        let mut coordinates = self.model.coordinates.iter();
        let mut inputs = self.model.inputs.iter();
        let column = name == "t"
            || coordinates.any(|c| ["q", "dq", "ddq"].iter().any(|group| is(group, &c.name)))
            || inputs.any(|u| is("u", &u.name));
        if column {
            let message = format!("a log has a column `{name}` already");
            return self
                .report(Diagnostic::error(span, message).help("give the sensor another name"));
        }
        if self.model.coordinates.iter().any(|c| c.name == name) {
            let message = format!("there is a coordinate named `{name}`, too");
            return self
                .report(Diagnostic::error(span, message).help("give the sensor another name"));
        }
        if self.model.sensors.iter().any(|sensor| sensor.name == name) {
            let message = format!("there are two sensors named `{name}`");
            return self.report(Diagnostic::error(span, message));
        }
        if self.model.outputs.iter().any(|output| output.name == name) {
            let message = format!("there is an output named `{name}`, too");
            return self
                .report(Diagnostic::error(span, message).help("give the sensor another name"));
        }
        Some(())
    }

    fn refuse_loads(&mut self, expr: ExprId, span: Span) -> Option<()> {
        let graph = &self.model.graph;
        let mut loads = self.loads.iter();
        if loads.any(|load| graph.depends_on(&[expr], load.symbol)) {
            let error = Diagnostic::error(span, "a sensor contains a load");
            return self.report(error.help("write what the drive exerts, from its inputs"));
        }
        Some(())
    }

    /// Multipliers follow from accelerations: how they change is not known.
    pub(super) fn refuse_rate_of_multiplier(&mut self, expr: ExprId, span: Span) -> Option<()> {
        let graph = &self.model.graph;
        let mut constraints = self.model.constraints.iter();
        let Some(found) = constraints.find(|c| graph.depends_on(&[expr], c.multiplier)) else {
            return Some(());
        };
        let name = &found.name;
        let message = format!("`dot` of something that contains the multiplier of `{name}`");
        self.report(Diagnostic::error(span, message).help("the rate of a multiplier is not known"))
    }

    /// Only a sensor sees accelerations.
    pub(super) fn refuse_outside_sensors(&mut self, function: &Name) -> Option<()> {
        if self.in_sensor {
            return Some(());
        }
        let message = format!("only a sensor reads `{}(…)`", function.text);
        let help = format!("state it in `sensor name = {}(…);`", function.text);
        self.report(Diagnostic::error(function.span, message).help(help))
    }

    /// `dot` of what contains velocities, in a sensor.
    pub(super) fn lower_acceleration(&mut self, inner: Quantity, span: Span) -> Option<Quantity> {
        if self.model.contains_acceleration(inner.expr) {
            let message = "`dot` of something that contains an acceleration";
            let help = "sensors read positions, velocities and accelerations";
            return self.report(Diagnostic::error(span, message).help(help));
        }
        self.refuse_rate_of_input(inner.expr, span)?;
        let seeds = self.model.true_time_seeds();
        Some(Quantity {
            expr: self.model.graph.directional(&[inner.expr], &seeds)[0],
            measure: inner.measure.rate(),
        })
    }

    /// One component of what an inertial sensor at a frame shows, along the frame's axes; of an
    /// acceleration, along the world's.
    pub(super) fn momentary_component(
        &mut self,
        function: &str,
        frame: usize,
        component: usize,
    ) -> Quantity {
        let acceleration = Dimension::LENGTH.rate().rate();
        let (expr, dimension) = match function {
            "acceleration" => {
                let reading = Reading::Acceleration(component);
                (self.model.reading(frame, reading), acceleration)
            }
            "angular_acceleration" => {
                let reading = Reading::AngularAcceleration(component);
                let dimension = Dimension::ANGLE.rate().rate();
                (self.model.reading(frame, reading), dimension)
            }
            "gyroscope" => {
                let turn =
                    [0, 1, 2].map(|k| self.model.reading(frame, Reading::AngularVelocity(k)));
                (self.along(frame, component, turn), Dimension::ANGLE.rate())
            }
            // What is left of the acceleration in free fall.
            _ => {
                let felt = [0, 1, 2].map(|k| {
                    let a = self.model.reading(frame, Reading::Acceleration(k));
                    self.model.graph.sub(a, self.model.tree.gravity[k])
                });
                (self.along(frame, component, felt), acceleration)
            }
        };
        Quantity {
            expr,
            measure: Measure::Known(dimension),
        }
    }

    /// `e · vector`, with `e` along an axis of a frame.
    fn along(&mut self, frame: usize, axis: usize, vector: [ExprId; 3]) -> ExprId {
        let axis = [0, 1, 2].map(|k| self.model.reading(frame, Reading::Axis(axis, k)));
        self.model.graph.inner_product(&axis, &vector)
    }

    /// `encoder_z(f, g)`: by how much `f` is turned against `g` about the z axis of `g`, in
    /// −π … π.
    pub(super) fn lower_encoder(
        &mut self,
        function: &Name,
        arguments: &[Expr],
        span: Span,
    ) -> Option<Quantity> {
        self.refuse_outside_sensors(function)?;
        let mut frames = Vec::new();
        for argument in arguments {
            let ExprKind::Name(name) = &argument.kind else {
                let message = format!("`{}` takes the names of two frames", function.text);
                return self.report(Diagnostic::error(argument.span, message));
            };
            frames.push(self.find_frame(name, argument.span)?);
        }
        let [turned, against] = frames[..] else {
            let message = format!(
                "`{}` takes two frames, found {}",
                function.text,
                frames.len()
            );
            return self.report(Diagnostic::error(span, message));
        };
        let about = ENCODERS.iter().position(|known| *known == function.text);
        let (j, k) = about.map_or((0, 1), |about| ((about + 1) % 3, (about + 2) % 3));
        let pointer = [0, 1, 2].map(|i| self.model.reading(turned, Reading::Axis(j, i)));
        let along = self.along(against, j, pointer);
        let across = self.along(against, k, pointer);
        Some(Quantity {
            expr: self.model.graph.binary(Binary::Atan2, across, along),
            measure: Measure::Known(Dimension::ANGLE),
        })
    }
}
