//! Python module of doublet: recordings, paths, coefficients, fits, sessions and their results, and single functions of arrays.
//!
//! Everything is computed by the engine and the crates below it; here arrays and names change hands. `python/doublet` builds on it
//! what a user sees: names, tables, plots.

mod aircraft;
mod arrays;
mod attend;
mod columns;
mod commands;
mod design;
mod equations;
mod fits;
mod flight;
mod judged;
mod output_error;
mod path;
mod predicted;
mod recording;
mod session;
mod settings;
mod statistics;

use pyo3::prelude::*;

/// The module: `doublet._doublet`.
#[pymodule]
mod _doublet {
    use super::{Bound, PyModule, PyModuleMethods, PyResult};
    #[pymodule_export]
    use crate::aircraft::Aircraft;
    #[pymodule_export]
    use crate::arrays::{differentiate, frequency_response, natural_modes, smooth};
    #[pymodule_export]
    use crate::attend::DoubletError;
    #[pymodule_export]
    use crate::commands::{command_table, run_command};
    #[pymodule_export]
    use crate::design::design_input;
    #[pymodule_export]
    use crate::equations::fit_function;
    #[pymodule_export]
    use crate::fits::{Coefficients, Fit, derivative_names};
    #[pymodule_export]
    use crate::flight::simulate;
    #[pymodule_export]
    use crate::path::Path;
    #[pymodule_export]
    use crate::recording::{Recording, guess_roles, roles, units};
    #[pymodule_export]
    use crate::session::{Results, Session};
    #[pymodule_export]
    use crate::settings::{filter_names, session_schema};
    #[pymodule_export]
    use crate::statistics::{coloured_covariance, lstsq};
    use pyo3::panic::PanicException;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::attend::note_process();
        // `python/doublet/_guard.py` makes an ordinary exception of it.
        module.add("PanicException", module.py().get_type::<PanicException>())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("instructions", doublet_core::reconstruct::instructions())
    }
}
