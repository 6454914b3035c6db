//! What path, sensors, clocks and the scatter between manoeuvres add to the errors of a session, and so to those of a design.

use std::collections::BTreeMap;

use super::rows::DesignRow;
use crate::session::{Estimation, Session, Surface};
use crate::snapshot::Snapshot;
use crate::stage::{CoefficientFit, applies};

/// Variance of each derivative beyond the noise of its fit, with the time of its manoeuvres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathShare {
    /// By derivative.
    parts: BTreeMap<String, Part>,
}

#[derive(Clone, Debug, PartialEq)]
struct Part {
    /// Variance beyond that of the noise.
    variance: f64,
    /// Time of the manoeuvres of the fit, s.
    time_s: f64,
    /// Whether a manoeuvre of one surface alone excites it: aileron, elevator, rudder.
    excited_by: [bool; 3],
}

impl PathShare {
    /// That of a session that was run; none where it has no pooled fit.
    pub fn measure(session: &Session, snapshot: &Snapshot) -> Option<Self> {
        let pooled = snapshot.pooled.ready()?;
        let parts = pooled.fits.iter().flat_map(|fit| fit_parts(fit, session));
        Some(Self { parts: parts.collect() })
    }

    /// Variance to expect of a derivative from manoeuvres of so many seconds: errors that the innovations and the scatter between
    /// manoeuvres show fall with the time flown, as the noise does. None of a derivative that was not fitted.
    fn variance(&self, name: &str, row: &DesignRow) -> Option<f64> {
        let part = self.parts.get(name)?;
        let surfaces = [Surface::Aileron, Surface::Elevator, Surface::Rudder];
        let own = row.manoeuvres.iter().filter(|manoeuvre| match manoeuvre.surfaces.as_slice() {
            [one] => surfaces.iter().zip(part.excited_by).any(|(surface, excites)| excites && surface.name() == *one),
            _ => true,
        });
        let time_s: f64 = own.map(|manoeuvre| manoeuvre.duration_s).sum();
        (time_s > 0.0).then(|| part.variance * part.time_s / time_s)
    }
}

fn fit_parts(fit: &CoefficientFit, session: &Session) -> Vec<(String, Part)> {
    let Ok(found) = &fit.fit else { return Vec::new() };
    let windows = fit.windows.iter().filter_map(|(name, _)| session.window(name));
    let time_s = windows.map(|window| window.window.end_s - window.window.start_s).sum();
    let errors = fit.corrected_errors.iter().zip(&fit.noise_errors);
    let excited_by = excited_by(fit, &session.estimation);
    let part = |(name, (all, noise)): (&String, (&f64, &f64))| {
        let variance = (all * all - noise * noise).max(0.0);
        (name.clone(), Part { variance, time_s, excited_by })
    };
    found.names.iter().zip(errors).map(part).collect()
}

fn excited_by(fit: &CoefficientFit, estimation: &Estimation) -> [bool; 3] {
    [Surface::Aileron, Surface::Elevator, Surface::Rudder]
        .map(|surface| applies(fit.coefficient, Some(surface), estimation))
}

impl DesignRow {
    /// Adds the errors of path and sensors of the session it starts from: the promised error.
    pub fn add_path(&mut self, share: &PathShare) {
        let added: Vec<Option<f64>> = self.predicted.iter().map(|own| share.variance(&own.name, self)).collect();
        for (own, variance) in self.predicted.iter_mut().zip(added) {
            own.path_error = variance.map(f64::sqrt);
            let noise = own.corrected;
            own.promised = noise.map(|noise| (noise * noise + variance.unwrap_or(0.0)).sqrt());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::{ManoeuvreRow, PredictedRow};

    fn predicted(name: &str, corrected: f64) -> PredictedRow {
        PredictedRow {
            name: name.to_owned(),
            estimate: 1.0,
            standard_error: None,
            corrected: Some(corrected),
            relative_error_percent: None,
            corrected_high: None,
            present: 0.0,
            path_error: None,
            promised: None,
        }
    }

    #[test]
    fn the_share_of_the_path_falls_with_the_time_of_the_manoeuvres_that_excite_it() {
        let part = |excited_by| Part { variance: 4.0, time_s: 100.0, excited_by };
        let parts = [("Cm_q".to_owned(), part([false, true, false])), ("Cl_p".to_owned(), part([true, false, true]))];
        let share = PathShare { parts: parts.into() };
        let manoeuvre = |surface: &'static str, duration_s| ManoeuvreRow {
            number: 1,
            name: String::new(),
            surfaces: vec![surface],
            duration_s,
            peak_rad: BTreeMap::new(),
            rate_rad_s: BTreeMap::new(),
            relative_peak_factor: BTreeMap::new(),
        };
        let mut row = DesignRow {
            kind: "doublet",
            surfaces: Vec::new(),
            time_s: 125.0,
            criterion: "d",
            costs: BTreeMap::new(),
            trim: BTreeMap::new(),
            gust_m_s: 0.0,
            band_hz: [0.0; 2],
            predicted: vec![predicted("Cm_q", 3.0), predicted("Cl_p", 3.0), predicted("CX_q", 3.0)],
            excursions: Vec::new(),
            manoeuvres: vec![manoeuvre("elevator", 25.0), manoeuvre("aileron", 60.0), manoeuvre("rudder", 40.0)],
            signal: Vec::new(),
            correlations: Vec::new(),
            samples: 0,
            failed_samples: 0,
            seed: 1,
            comparison: Vec::new(),
            notes: Vec::new(),
        };
        row.add_path(&share);
        let promised: Vec<f64> = row.predicted.iter().filter_map(|own| own.promised).collect();
        // 4 * 100 / 25 and 4 * 100 / 100 beside 9; a derivative that was not fitted has its noise alone.
        assert_eq!(promised, [5.0, 13f64.sqrt(), 3.0]);
        assert_eq!(row.predicted[0].path_error, Some(4.0));
        assert_eq!(row.predicted[2].path_error, None);
    }
}
