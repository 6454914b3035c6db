//! Central differences of derivatives, as the thesis tabulates them, and their order for a tornado chart.

use super::quantity::Step;

/// Change of one derivative with one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Partial {
    /// Name of the derivative.
    pub derivative: String,
    /// Estimate with the quantity as it is.
    pub nominal: f64,
    /// Estimate with the quantity one step lower.
    pub low: f64,
    /// Estimate with the quantity one step higher.
    pub high: f64,
    /// `(high - low) / (2 step)`, per unit of the quantity (thesis Eq. 7.1).
    pub partial: f64,
    /// `100 (high - low) / (2 |nominal|)`: change of the derivative over one step, per cent of itself.
    pub relative_percent: f64,
    /// `(high - low) / 2` in standard errors of the nominal estimate: above one, this quantity matters more than the scatter.
    pub in_standard_errors: f64,
}

/// All derivatives against one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct SensitivityTable {
    /// Quantity, its value and step.
    pub step: Step,
    /// One entry per derivative.
    pub partials: Vec<Partial>,
}

/// One bar of a tornado chart.
#[derive(Clone, Debug, PartialEq)]
pub struct TornadoBar {
    /// Derivative.
    pub derivative: String,
    /// Quantity, by name.
    pub quantity: String,
    /// Change of the derivative from nominal to the lower and to the upper end of the step, per cent of itself.
    pub change_percent: [f64; 2],
    /// Half the span in standard errors of the estimate.
    pub in_standard_errors: f64,
}

/// A named estimate with its standard error.
pub type Estimate = (String, f64, f64);

/// Central difference of every derivative in `nominal` (name, estimate, standard error); `low` and `high` hold the estimates one
/// step below and above, by name. Derivatives that either side lacks are left out.
pub fn central(step: Step, nominal: &[Estimate], low: &[Estimate], high: &[Estimate]) -> SensitivityTable {
    SensitivityTable {
        partials: nominal.iter().filter_map(|estimate| difference(&step, estimate, low, high)).collect(),
        step,
    }
}

fn difference(step: &Step, (name, value, error): &Estimate, low: &[Estimate], high: &[Estimate]) -> Option<Partial> {
    let find = |side: &[Estimate]| side.iter().find(|(other, ..)| other == name).map(|(_, value, _)| *value);
    let (low, high) = (find(low)?, find(high)?);
    let half = 0.5 * (high - low);
    Some(Partial {
        derivative: name.clone(),
        nominal: *value,
        low,
        high,
        partial: half / step.half_width,
        relative_percent: 100.0 * half / value.abs(),
        in_standard_errors: half / error,
    })
}

/// Bars of a tornado chart: derivative by derivative in the order of the first table, widest bar first.
pub fn tornado(tables: &[SensitivityTable]) -> Vec<TornadoBar> {
    let Some(first) = tables.first() else { return Vec::new() };
    let mut bars = Vec::new();
    for Partial { derivative, .. } in &first.partials {
        let mut own: Vec<TornadoBar> = tables.iter().filter_map(|table| measure_bar(table, derivative)).collect();
        let width = |bar: &TornadoBar| (bar.change_percent[1] - bar.change_percent[0]).abs();
        own.sort_by(|a, b| width(b).total_cmp(&width(a)));
        bars.extend(own);
    }
    bars
}

fn measure_bar(table: &SensitivityTable, derivative: &str) -> Option<TornadoBar> {
    let found = table.partials.iter().find(|partial| partial.derivative == derivative)?;
    let percent = |value: f64| 100.0 * (value - found.nominal) / found.nominal.abs();
    Some(TornadoBar {
        derivative: derivative.to_owned(),
        quantity: table.step.quantity.name(),
        change_percent: [percent(found.low), percent(found.high)],
        in_standard_errors: found.in_standard_errors,
    })
}

#[cfg(test)]
mod tests {
    use super::super::Quantity;
    use super::*;

    #[test]
    fn tornado_puts_the_widest_bar_of_each_derivative_first() {
        let step = |quantity| Step { quantity, nominal: 100.0, half_width: 5.0 };
        let estimate = |name: &str, value: f64| (name.to_owned(), value, 0.5);
        let nominal = [estimate("Cm_alpha", -1.0), estimate("Cm_q", -10.0)];
        let narrow = central(
            step(Quantity::AlphaScale),
            &nominal,
            &[estimate("Cm_alpha", -1.01), estimate("Cm_q", -12.0)],
            &[estimate("Cm_alpha", -0.99), estimate("Cm_q", -8.0)],
        );
        let wide = central(step(Quantity::Iyy), &nominal, &[estimate("Cm_alpha", -0.9)], &[estimate("Cm_alpha", -1.1)]);
        approx::assert_relative_eq!(narrow.partials[1].partial, 0.4, epsilon = 1e-15);
        approx::assert_relative_eq!(narrow.partials[1].relative_percent, 20.0, epsilon = 1e-12);
        approx::assert_relative_eq!(narrow.partials[1].in_standard_errors, 4.0, epsilon = 1e-12);
        let bars = tornado(&[narrow, wide]);
        let order: Vec<(&str, &str)> =
            bars.iter().map(|bar| (bar.derivative.as_str(), bar.quantity.as_str())).collect();
        assert_eq!(order, [("Cm_alpha", "Iyy"), ("Cm_alpha", "alpha"), ("Cm_q", "alpha")]);
        approx::assert_relative_eq!(bars[0].change_percent[0], 10.0, epsilon = 1e-12);
    }
}
