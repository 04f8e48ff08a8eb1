//! A model in motion, with what tests ask of it.

use dynamics_codegen::{Library, System, Tape, compile};
use identify::machine::{
    ContactTerms, Impact, Machine, Simulated, States, Stepping, SteppingOptions,
};

pub struct Case {
    pub machine: Machine,
    pub parameters: Vec<f64>,
    energy: Tape,
}

/// What a motion leads to.
pub struct Moved {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    /// Sweeps of the solver.
    pub sweeps: usize,
    pub relaxed: usize,
}

impl Case {
    pub fn new(text: &str) -> Self {
        let mut library = Library::builtin();
        library.look_in(concat!(env!("CARGO_MANIFEST_DIR"), "/../models"));
        let compiled = match compile("contact.model", text, &library) {
            Ok(compiled) => compiled,
            Err(report) => panic!("{report}"),
        };
        let (model, system) = (&compiled.model, &compiled.system);
        let energies = [system.kinetic_energy, system.potential_energy];
        let energy = Tape::new(&model.graph, &energies, &System::arguments(model));
        let machine = Machine::new(compiled);
        Self {
            parameters: machine.nominal_parameters(),
            machine,
            energy,
        }
    }

    /// Sets a parameter.
    pub fn with(mut self, name: &str, value: f64) -> Self {
        let parameters = &self.machine.compiled.model.parameters;
        let index = parameters.iter().position(|p| p.name == name).unwrap();
        self.parameters[index] = value;
        self
    }

    pub fn states(&self, t: f64, q: &[f64], v: &[f64]) -> States {
        let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
        States {
            t: vec![t],
            q: column(q),
            v: column(v),
            u: vec![vec![0.0]; self.machine.input_count()],
            ..States::default()
        }
    }

    pub fn contacts(&self, t: f64, q: &[f64], v: &[f64]) -> ContactTerms {
        let states = self.states(t, q, v);
        self.machine
            .contact_terms(&states, &self.parameters)
            .remove(0)
    }

    /// `T + V`, J.
    pub fn energy(&self, q: &[f64], v: &[f64]) -> f64 {
        let inputs = vec![0.0; self.machine.input_count()];
        let arguments = [&[0.0][..], q, v, &inputs, &self.parameters].concat();
        self.energy.evaluate(&arguments).iter().sum()
    }

    /// Moves from `q, v` in steps of `h`; after each one `seen` is told `t, q, v` and the impulses of
    /// that step.
    pub fn run(
        &self,
        (q, v): (&[f64], &[f64]),
        h: f64,
        steps: usize,
        mut seen: impl FnMut(f64, &[f64], &[f64], &[f64]),
    ) -> Moved {
        let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
        let row = |columns: &[Vec<f64>]| -> Vec<f64> { columns.iter().map(|c| c[0]).collect() };
        let options = SteppingOptions {
            max_step: h,
            ..SteppingOptions::default()
        };
        let mut stepping = Stepping::new(&self.machine, &self.parameters, options);
        let u: Vec<Vec<f64>> = vec![vec![0.0]; self.machine.input_count()];
        let mut state = Simulated {
            q: column(q),
            v: column(v),
            z: Vec::new(),
        };
        for step in 0..steps {
            let t = step as f64 * h;
            let moved = stepping.advance(&mut state, t, h, &u, &u);
            moved.unwrap_or_else(|error| panic!("at t = {t}: {error}"));
            let impulse = stepping.take_impulse();
            seen(t + h, &row(&state.q), &row(&state.v), impulse.as_slice());
        }
        Moved {
            q: row(&state.q),
            v: row(&state.v),
            sweeps: stepping.sweeps(),
            relaxed: stepping.relaxed(),
        }
    }

    /// Impacts at their instants on the way from `q, v`.
    pub fn impacts(&self, (q, v): (&[f64], &[f64]), h: f64, steps: usize) -> Vec<Impact> {
        let options = SteppingOptions {
            max_step: h,
            exact_impacts: true,
            ..SteppingOptions::default()
        };
        let mut stepping = Stepping::new(&self.machine, &self.parameters, options);
        let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
        let u: Vec<Vec<f64>> = vec![vec![0.0]; self.machine.input_count()];
        let mut state = Simulated {
            q: column(q),
            v: column(v),
            z: Vec::new(),
        };
        let moved = stepping.advance(&mut state, 0.0, h * steps as f64, &u, &u);
        moved.unwrap_or_else(|error| panic!("{error}"));
        stepping.take_impacts()
    }
}
