//! The Python package `dynamics`: what is computed for it. What is shown, drawn and read from
//! frames stands in `package/dynamics`, in Python.

mod answer;
mod arrays;
mod batch;
mod calls;
mod derivatives;
mod error;
mod fit;
mod free;
mod latent;
mod log;
mod machine_code;
mod model;
mod place;
mod report;
mod simulate;
mod terms;
mod trace;
mod wait;

use pyo3::prelude::*;

/// As in the command line: filters and solvers allocate many small matrices.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// What the package `dynamics` calls; its interface is that of the package.
#[pymodule(gil_used = true)]
mod _native {
    #[pymodule_export]
    use crate::derivatives::Derivatives;
    #[pymodule_export]
    use crate::error::{Error, SolveError};
    #[pymodule_export]
    use crate::fit::fit_logs;
    #[pymodule_export]
    use crate::latent::{Learnt, learn};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::report::Report;
    #[pymodule_export]
    use crate::simulate::Simulation;
    #[pymodule_export]
    use crate::trace::trace_logs;
}
