//! `Model`: a model file at states that Python has.

use crate::error::{Error, mistaken};
use crate::machine_code::{Failure, MachineCode};
use crate::terms::{Equations, Wanted};
use crate::wait::wait;
use cli::model::ModelArguments;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A model with its equations of motion.
#[pyclass(frozen, module = "dynamics")]
pub struct Model {
    pub equations: Arc<Equations>,
    /// The parameters' values, in the model's order.
    pub values: Vec<f64>,
    /// Its terms as machine code, once it is compiled.
    pub code: Option<Arc<MachineCode>>,
    /// What should be known about the model.
    #[pyo3(get)]
    warnings: Vec<String>,
}

impl Model {
    /// What reads a velocity beside every position has no place for a body that floats by its twist.
    ///
    /// # Errors
    /// If one does.
    pub fn refuse_twist(&self) -> PyResult<()> {
        let Some(pose) = self.equations.loaded.compiled.model.poses.first() else {
            return Ok(());
        };
        let message = format!(
            "`{}` floats by its twist, and here every position has a velocity of its own: \
             leave `velocities: twist` out of the model, or write `velocities: rates`",
            pose.name
        );
        Err(Error::new_err(message))
    }
}

#[pymethods]
impl Model {
    /// Reads a model.
    ///
    /// Args:
    ///     path: a `.model` file or a robot description (URDF or MJCF).
    ///     parameters: values in place of the nominal ones: a mapping from names to numbers, or
    ///         the path of a JSON file.
    ///     effects: folders of your own effect templates; they win over the built-in ones.
    ///
    /// Returns:
    ///     The model. What should be known about it stands in `warnings`.
    ///
    /// Raises:
    ///     dynamics.Error: if the file cannot be read or is wrong; the message says every place,
    ///         what was expected and how to mend it.
    #[staticmethod]
    #[pyo3(signature = (path, *, parameters=None, effects=Vec::new()))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        parameters: Option<&Bound<'_, PyAny>>,
        effects: Vec<PathBuf>,
    ) -> PyResult<Self> {
        let file = match parameters {
            Some(given) if !given.hasattr("keys")? => Some(given.extract::<PathBuf>()?),
            _ => None,
        };
        let arguments = ModelArguments {
            model: path,
            effects,
            parameters: file,
        };
        let (loaded, warnings) = py
            .detach(|| arguments.read())
            .map_err(|mistake| mistaken(&mistake))?;
        let mut said: Vec<String> = warnings
            .iter()
            .map(|warning| warning.render_as_warning(false))
            .collect();
        if !loaded.compiled.warnings.diagnostics.is_empty() {
            said.insert(0, loaded.compiled.warnings.render());
        }
        let values = loaded.parameters.clone();
        let model = Self {
            equations: Arc::new(Equations::new(loaded)),
            values,
            code: None,
            warnings: said,
        };
        match parameters {
            Some(given) if given.hasattr("keys")? => model.with_parameters(given),
            _ => Ok(model),
        }
    }

    /// The same model with other values of some parameters; nothing is compiled again.
    ///
    /// Args:
    ///     parameters: names and numbers, in the parameters' units. What is not named keeps its value.
    ///
    /// Returns:
    ///     A new model.
    ///
    /// Raises:
    ///     dynamics.Error: if there is no such parameter, or a number is not finite.
    fn with_parameters(&self, parameters: &Bound<'_, PyAny>) -> PyResult<Self> {
        let known = &self.equations.loaded.compiled.model.parameters;
        let mut values = self.values.clone();
        let items = PyDict::new(parameters.py());
        items.update(parameters.cast()?)?;
        for (name, value) in items {
            let (name, value): (String, f64) = (name.extract()?, value.extract()?);
            let Some(index) = known.iter().position(|p| p.name == name) else {
                let names: Vec<&str> = known.iter().map(|p| p.name.as_str()).collect();
                let message = format!(
                    "the model has no parameter `{name}`; it has: {}",
                    names.join(", ")
                );
                return Err(Error::new_err(message));
            };
            if !value.is_finite() {
                let message = format!("parameter `{name}` is {value}; give a finite number");
                return Err(Error::new_err(message));
            }
            values[index] = value;
        }
        Ok(Self {
            equations: Arc::clone(&self.equations),
            values,
            code: self.code.clone(),
            warnings: self.warnings.clone(),
        })
    }

    /// The same model with its terms as machine code: several times as fast for many states.
    ///
    /// The emitted C is compiled and loaded; that takes seconds. Compiled are `mass_matrix`,
    /// `bias_force`, `applied_force`, `input_matrix`, `inverse_dynamics` and the terms of the
    /// constraints; the numbers stay the same. `forward_dynamics` without constraints uses them;
    /// everything else is computed as before.
    ///
    /// Args:
    ///     compiler: a C compiler that takes the options of GCC.
    ///     options: further ones.
    ///
    /// Returns:
    ///     A new model.
    ///
    /// Raises:
    ///     dynamics.Error: if the model has internal states, delays or forces that depend on a
    ///         multiplier; if there is no such compiler, or it fails.
    #[pyo3(signature = (*, compiler="cc".to_owned(), options=vec!["-O3".to_owned(), "-march=native".to_owned()]))]
    fn compile(&self, py: Python<'_>, compiler: String, options: Vec<String>) -> PyResult<Self> {
        let equations = Arc::clone(&self.equations);
        let name = compiler.clone();
        let work = move || {
            let size = |term| equations.shape(Wanted::Term(term)).iter().product();
            MachineCode::new(&equations.loaded.compiled, &compiler, &options, size)
        };
        let made = wait(py, &Arc::new(AtomicBool::new(false)), work)?;
        let code = made.map_err(|failure| {
            Error::new_err(match failure {
                Failure::Model(reason) => reason.to_owned(),
                Failure::Compiler(said) => said,
                Failure::System(error) => format!(
                    "`{name}` cannot be called: {error}; give a C compiler, such as `compiler=\"gcc\"`"
                ),
            })
        })?;
        Ok(Self {
            equations: Arc::clone(&self.equations),
            values: self.values.clone(),
            code: Some(Arc::new(code)),
            warnings: self.warnings.clone(),
        })
    }

    /// Whether its terms are machine code; see `compile`.
    #[getter]
    fn is_compiled(&self) -> bool {
        self.code.is_some()
    }

    /// What the model calls itself.
    #[getter]
    fn name(&self) -> &str {
        &self.equations.loaded.compiled.model.name
    }

    /// The file it was read from.
    #[getter]
    fn path(&self) -> PathBuf {
        self.equations.loaded.path.clone()
    }

    /// The model as text. Of a robot description, the model that names it.
    #[getter]
    fn text(&self) -> String {
        self.equations.loaded.text().0
    }

    /// Names of the positions, in the order of `q`: those of the coordinates, but of a body that floats
    /// by its twist the seven of its pose in place of the six of its twist.
    #[getter]
    fn positions(&self) -> Vec<String> {
        self.equations.positions.clone()
    }

    /// Names of the n coordinates, in the order of all arrays; `q` has the order of `positions`.
    #[getter]
    fn coordinates(&self) -> Vec<String> {
        self.equations.coordinates.clone()
    }

    /// Names of the k inputs, in the order of all arrays.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.equations.inputs.clone()
    }

    /// Names of the s internal states (bristles of a friction law, lags), in the order of `z`.
    #[getter]
    fn states(&self) -> Vec<String> {
        self.equations.states.clone()
    }

    /// Names of the m constraints, in the order of multipliers and rows.
    #[getter]
    fn constraints(&self) -> Vec<String> {
        let constraints = &self.equations.loaded.compiled.model.constraints;
        constraints.iter().map(|c| c.name.clone()).collect()
    }

    /// Names of frames and bodies, in alphabetical order; of a robot description its links.
    #[getter]
    fn frames(&self) -> Vec<String> {
        let frames = self.equations.loaded.compiled.model.frames();
        frames.into_keys().map(str::to_owned).collect()
    }

    /// The parameters' values by name, in the units of `units`.
    #[getter]
    fn parameters(&self) -> BTreeMap<String, f64> {
        let known = self.equations.loaded.compiled.model.parameters.iter();
        let named = known.zip(&self.values);
        named.map(|(p, &value)| (p.name.clone(), value)).collect()
    }

    /// Units by the names of positions, inputs and parameters.
    #[getter]
    fn units(&self) -> BTreeMap<String, String> {
        let model = &self.equations.loaded.compiled.model;
        let inputs = model
            .inputs
            .iter()
            .map(|u| (u.name.clone(), u.unit.clone()));
        let parameters = model.parameters.iter();
        let parameters = parameters.map(|p| (p.name.clone(), p.unit.clone()));
        let positions = model.positions().into_iter().map(|p| (p.name, p.unit));
        parameters.chain(inputs).chain(positions).collect()
    }

    fn __repr__(&self) -> String {
        let model = &self.equations.loaded.compiled.model;
        format!(
            "<Model {}: {} coordinates, {} inputs, {} constraints, {} parameters>",
            model.name,
            model.coordinates.len(),
            model.inputs.len(),
            model.constraints.len(),
            model.parameters.len()
        )
    }

    /// Names of the model's outputs, in the order of `outputs`.
    #[getter]
    fn output_names(&self) -> Vec<String> {
        let outputs = &self.equations.loaded.compiled.model.outputs;
        outputs.iter().map(|output| output.name.clone()).collect()
    }
}
