//! Settings of the filter as Python gives them.

use doublet_core::reconstruct::{
    FilterSettings, Input, InputHold, Linearisation, Measurement, Method, SettingError, State,
};
use doublet_engine::session::GravitySource;
use pyo3::prelude::*;

use crate::attend::refuse;

/// Values by the name of an input, a measurement or a state, SI.
type Values = Vec<(String, f64)>;

/// Settings by the names of the arguments of `doublet.reconstruct`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct FilterGiven {
    method: String,
    hold: String,
    linearisation: String,
    gravity: Option<f64>,
    noise: Values,
    delays: Values,
    random_walk: Values,
    initial_state: Values,
    initial_std: Values,
    outlier_limit: Option<f64>,
    robust_limit: f64,
    pub smooth: bool,
    passes: usize,
}

impl FilterGiven {
    /// The settings of the engine, and where gravity comes from.
    pub fn settings(&self) -> PyResult<(FilterSettings, GravitySource)> {
        let mut settings = FilterSettings {
            method: self.method()?,
            hold: match self.hold.as_str() {
                "first_order" => InputHold::FirstOrder,
                "zero_order" => InputHold::ZeroOrder,
                other => return Err(refuse(format!("'{other}' is not a hold: use first_order or zero_order"))),
            },
            linearisation: match self.linearisation.as_str() {
                "prior" => Linearisation::Prior,
                "predicted" => Linearisation::Predicted,
                other => return Err(refuse(format!("'{other}' is not a linearisation: use prior or predicted"))),
            },
            smooth: self.smooth,
            smoother_passes: self.passes,
            robust_limit: self.robust_limit,
            ..FilterSettings::default()
        };
        self.fill_noise(&mut settings)?;
        for (name, value) in &self.random_walk {
            settings.random_walk[state(name)? as usize] = *value;
        }
        for (name, value) in &self.initial_state {
            settings.initial_state[state(name)? as usize] = Some(*value);
        }
        for (name, value) in &self.initial_std {
            settings.initial_deviation[state(name)? as usize] = *value;
        }
        settings.outlier_limit = self.outlier_limit.unwrap_or(settings.outlier_limit);
        let source = match self.gravity {
            Some(m_s2) => {
                settings.gravity_m_s2 = m_s2;
                GravitySource::Stated
            }
            None => GravitySource::Position,
        };
        let wrong = |errors: Vec<SettingError>| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        settings.check().map_err(|errors| refuse(wrong(errors)))?;
        Ok((settings, source))
    }

    fn method(&self) -> PyResult<Method> {
        match self.method.as_str() {
            "ekf" => Ok(Method::Ekf),
            "iekf" => Ok(Method::USUAL_IEKF),
            "ukf" => Ok(Method::Ukf { spread: Method::USUAL_SPREAD }),
            other => Err(refuse(format!("'{other}' is not a filter: use ekf, iekf or ukf"))),
        }
    }

    fn fill_noise(&self, settings: &mut FilterSettings) -> PyResult<()> {
        let unknown = |name: &str| {
            let inputs = Input::ALL.map(Input::name).into_iter();
            let known: Vec<_> = inputs.chain(Measurement::ALL.map(Measurement::name)).collect();
            let known = known.join(", ");
            refuse(format!("'{name}' is neither an input nor a measurement of the filter: use one of {known}"))
        };
        for (name, deviation) in &self.noise {
            match (Input::from_name(name), Measurement::from_name(name)) {
                (Some(input), _) => settings.process_noise[input as usize] = *deviation,
                (None, Some(measurement)) => settings.measurement_noise[measurement as usize] = *deviation,
                (None, None) => return Err(unknown(name)),
            }
        }
        for (name, delay_s) in &self.delays {
            let measurement = Measurement::from_name(name).ok_or_else(|| unknown(name))?;
            settings.measurement_delay_s[measurement as usize] = *delay_s;
        }
        Ok(())
    }
}

fn state(name: &str) -> PyResult<State> {
    let known = || State::ALL.map(State::name).join(", ");
    State::from_name(name)
        .ok_or_else(|| refuse(format!("'{name}' is not a state of the filter: use one of {}", known())))
}
