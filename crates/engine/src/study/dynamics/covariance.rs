//! Correlation of the estimates of all coefficients together.

use doublet_core::estimate::{PooledFit, PooledWindow, joint_coloured_covariance};
use doublet_core::model::Structure;
use nalgebra::DMatrix;

use crate::session::Estimation;
use crate::stage::{AeroWindow, CoefficientFit, pooled_regressions};
use crate::study::IdentifiedCoefficient;

/// Covariance of the estimated parameters of these fits, within and across coefficients, in their order, by
/// [`joint_coloured_covariance`] of their regressions over the windows: from the residuals, without the errors of the flight path.
///
/// None where a regression cannot be formed again.
pub fn joint_covariance(
    fits: &[&CoefficientFit],
    windows: &[AeroWindow<'_>],
    (structure, estimation): (&Structure, &Estimation),
) -> Option<DMatrix<f64>> {
    let regressions = pooled_regressions(windows, structure, estimation);
    let mut joint: Vec<(PooledFit, Vec<PooledWindow>)> = Vec::with_capacity(fits.len());
    for fit in fits {
        let is_same_coefficient = |regression: &&crate::stage::Regression| regression.coefficient == fit.coefficient;
        let regression = regressions.iter().flatten().find(is_same_coefficient)?;
        let again = regression.pooled.fit().ok()?;
        if again.fit.names != fit.fit.as_ref().ok()?.names {
            return None;
        }
        joint.push((again, regression.pooled.windows.clone()));
    }
    let pairs: Vec<_> = joint.iter().map(|(fit, windows)| (fit, windows.as_slice())).collect();
    joint_coloured_covariance(&pairs).ok()
}

/// Correlation of the derivatives of these coefficients, within and across, in their order: by [`joint_covariance`] and what each
/// derivative is of the estimated parameters.
///
/// None where a regression cannot be formed again.
pub(super) fn correlation(
    fits: &[(&CoefficientFit, &IdentifiedCoefficient)],
    windows: &[AeroWindow<'_>],
    settings: (&Structure, &Estimation),
) -> Option<DMatrix<f64>> {
    let estimated: Vec<_> = fits.iter().map(|(fit, _)| *fit).collect();
    let covariance = joint_covariance(&estimated, windows, settings)?;
    let derivatives = fits.iter().map(|(_, coefficient)| coefficient.parameters.len()).sum();
    let mut shares = DMatrix::zeros(derivatives, covariance.nrows());
    let mut place = (0, 0);
    for (_, IdentifiedCoefficient { shares: own, .. }) in fits {
        shares.view_mut(place, own.shape()).copy_from(own);
        place = (place.0 + own.nrows(), place.1 + own.ncols());
    }
    let covariance = &shares * covariance * shares.transpose();
    let sigma = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
    Some(DMatrix::from_fn(derivatives, derivatives, |i, j| {
        let scale = sigma[i] * sigma[j];
        if i == j {
            1.0
        } else if scale > 0.0 {
            covariance[(i, j)] / scale
        } else {
            0.0
        }
    }))
}
