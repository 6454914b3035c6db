//! Sessions of older versions that are brought forward.

use doublet_core::estimate::SensorError;
use doublet_engine::builtin;
use doublet_engine::session::{self, Configuration, Experiment, PredictionParameters, WindowRole};

#[test]
fn version_4_called_manoeuvres_windows() {
    let mut session = session::parse(builtin::session("demo").unwrap()).unwrap();
    let first = session.windows[0].clone();
    let mut configuration = Configuration::from_session(&session);
    configuration.manoeuvres[0].role = WindowRole::Ignored;
    configuration.estimation.predict_with = PredictionParameters::ManoeuvreMeans;
    session.experiments = vec![Experiment { name: "one".to_owned(), configuration: configuration.into() }];
    session.sensor_errors.per_window = vec![SensorError::from_name("bias_beta").unwrap()];
    let text = session::print(&session).unwrap();
    assert!(text.contains("[[manoeuvre]]") && text.contains("[[experiment.manoeuvre]]") && !text.contains("window"));
    let older = text
        .replace("version = 6", "version = 4")
        .replace("[[manoeuvre]]", "[[window]]")
        .replace("[[experiment.manoeuvre]]", "[[experiment.window]]")
        .replace("per_manoeuvre", "per_window")
        .replace("manoeuvre_means", "window_means");
    let read = session::parse(&older).unwrap();
    assert_eq!(read, session);
    assert_eq!(read.windows[0], first);
}
