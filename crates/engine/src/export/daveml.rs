//! DAVE-ML 2.0: the model as variable definitions with MathML, uncertainties and check cases.

use doublet_core::model::{Coefficient, Gyroscopic, Term, ThrustTreatment, Variable};

use super::checks::{Input, Normalisation, inputs, normalisation, normalised_name, points};
use super::xml::{Document, number};
use super::{ExportError, IdentifiedCoefficient, IdentifiedModel, MARK};

/// Name space of MathML.
const MATHML: &str = "http://www.w3.org/1998/Math/MathML";

/// The whole file.
pub fn write(model: &IdentifiedModel, date: &str) -> Result<String, ExportError> {
    let mut document = Document::new()?;
    document.doctype(r#"DAVEfunc PUBLIC "-//AIAA//DTD for Flight Dynamic Models - Functions 2.0//EN" "http://daveml.org/DTDs/2p0/DAVEfunc.dtd""#)?;
    document.element("DAVEfunc", &[("xmlns", "http://daveml.org/2010/DAVEML")], |d| {
        header(d, model, date)?;
        for input in inputs(model) {
            input_definition(d, model, &input)?;
        }
        reference_lengths(d, model)?;
        for variable in model.variables() {
            if let Some(normalisation) = normalisation(model, variable) {
                rate_definition(d, model, variable, &normalisation)?;
            }
        }
        for coefficient in &model.coefficients {
            parameters(d, coefficient)?;
        }
        for coefficient in &model.coefficients {
            output_definition(d, model, coefficient)?;
        }
        check_data(d, model)
    })?;
    document.finish()
}

fn header(d: &mut Document, model: &IdentifiedModel, date: &str) -> Result<(), ExportError> {
    d.element("fileHeader", &[("name", &model.aircraft)], |d| {
        let version = crate::PROGRAM.to_owned();
        d.empty("author", &[("name", version.as_str()), ("org", "")])?;
        d.empty("creationDate", &[("date", date)])?;
        d.text("fileVersion", &[], "1")?;
        d.text("description", &[], &format!("{}; {MARK}. {}", model.title, statement(model)))
    })
}

/// Axes, reference point, thrust and errors in words.
pub fn statement(model: &IdentifiedModel) -> String {
    let [x, y, z] = model.moment_reference_datum_m.map(number);
    let point =
        if model.about_centre_of_gravity { "the mean centre of gravity of the manoeuvres identified, " } else { "" };
    let thrust = match model.thrust {
        ThrustTreatment::Included => {
            "The coefficients include force and moment of the thrust: valid only at the power flown."
        }
        ThrustTreatment::ForceRemoved => {
            "The coefficients include the moment of the thrust but not its force: valid only at the power flown."
        }
        ThrustTreatment::Removed => "Thrust is not in the coefficients.",
    };
    let rotors = match model.gyroscopic {
        Gyroscopic::Signed => "",
        Gyroscopic::Summed => " The gyroscopic moment taken out is that of propellers that all turn the same way.",
        Gyroscopic::Ignored => " The gyroscopic moment of the propellers is inside the coefficients.",
    };
    let lag = match model.control_lags.shared_s() {
        Some(0.0) => String::new(),
        Some(lag_s) => format!(" Deflections act through a first-order lag of {} s.", number(lag_s)),
        None => format!(" Deflections act late (first-order lag, delay): {}.", model.control_lags.summary()),
    };
    let mean = if model.coefficients.iter().any(|c| c.mean_constant) {
        " Constants are means of one constant per manoeuvre, weighted by samples."
    } else {
        ""
    };
    format!(
        "Coefficients CX CY CZ of forces and Cl Cm Cn of moments in body axes (x forward, y right, z down), force / (q S), moment / \
         (q S b) and (q S c); moments about {point}x {x} m, y {y} m, z {z} m in datum axes (x aft, y right, z up; origin: {}). \
         {thrust}{rotors}{lag}{mean} Errors are one standard deviation, corrected for residuals correlated in time; ranges are those of the \
         manoeuvres identified, and nothing is limited to them.",
        model.datum
    )
}

fn range(model: &IdentifiedModel, variable: Variable) -> String {
    match model.ranges.get(&variable) {
        Some((low, high)) => format!("; identified from {low:.6} to {high:.6}"),
        None => String::new(),
    }
}

fn input_definition(d: &mut Document, model: &IdentifiedModel, input: &Input) -> Result<(), ExportError> {
    let attributes = [("name", input.signal), ("varID", input.name), ("units", input.unit)];
    d.element("variableDef", &attributes, |d| {
        let range =
            if normalisation(model, input.variable).is_none() { range(model, input.variable) } else { String::new() };
        d.text("description", &[], &format!("{}{range}", input.description))?;
        d.empty("isInput", &[])
    })
}

fn reference_lengths(d: &mut Document, model: &IdentifiedModel) -> Result<(), ExportError> {
    let reference = &model.reference;
    let [x, y, z] = model.moment_reference_datum_m;
    for (name, id, unit, value, description) in [
        ("referenceWingArea", "S", "m2", reference.area_m2, "reference area"),
        (
            "referenceWingSpan",
            "b",
            "m",
            reference.lateral_moment_length_m,
            "reference length of Cl, Cn, roll and yaw rate",
        ),
        ("referenceWingChord", "c", "m", reference.chord_m, "reference length of Cm and pitch rate"),
        ("momentReference_X", "x_ref", "m", x, "moment reference, datum axes, positive aft"),
        ("momentReference_Y", "y_ref", "m", y, "moment reference, datum axes, positive right"),
        ("momentReference_Z", "z_ref", "m", z, "moment reference, datum axes, positive up"),
    ] {
        let value = number(value);
        let attributes = [("name", name), ("varID", id), ("units", unit), ("initialValue", &value)];
        d.element("variableDef", &attributes, |d| d.text("description", &[], description))?;
    }
    Ok(())
}

fn identifier(model: &IdentifiedModel, variable: Variable) -> String {
    let input = inputs(model).into_iter().find(|input| input.variable == variable);
    let name = input.map_or(variable.suffix(), |input| input.name);
    if normalisation(model, variable).is_some() { format!("{name}_hat") } else { name.to_owned() }
}

fn rate_definition(
    d: &mut Document,
    model: &IdentifiedModel,
    variable: Variable,
    normalisation: &Normalisation,
) -> Result<(), ExportError> {
    let id = identifier(model, variable);
    let rate = id.trim_end_matches("_hat").to_owned();
    let written = normalised_name(model, variable).unwrap_or_default();
    let attributes = [("name", id.as_str()), ("varID", id.as_str()), ("units", "nd")];
    d.element("variableDef", &attributes, |d| {
        d.text("description", &[], &format!("{written}{}", range(model, variable)))?;
        calculation(d, |d| {
            apply(d, "divide", |d| {
                apply(d, "times", |d| {
                    d.text("ci", &[], &rate)?;
                    d.text("ci", &[], normalisation.symbol)
                })?;
                if normalisation.divisor == 1.0 {
                    return d.text("ci", &[], "V");
                }
                apply(d, "times", |d| {
                    d.number("cn", normalisation.divisor)?;
                    d.text("ci", &[], "V")
                })
            })
        })
    })
}

fn calculation(
    d: &mut Document,
    content: impl FnOnce(&mut Document) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    d.element("calculation", &[], |d| d.element("math", &[("xmlns", MATHML)], content))
}

fn apply(
    d: &mut Document,
    operator: &str,
    operands: impl FnOnce(&mut Document) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    d.element("apply", &[], |d| {
        d.empty(operator, &[])?;
        operands(d)
    })
}

/// Derivatives with their errors; the correlation of a pair stands with the later of the two.
fn parameters(d: &mut Document, coefficient: &IdentifiedCoefficient) -> Result<(), ExportError> {
    for (index, parameter) in coefficient.parameters.iter().enumerate() {
        let value = number(parameter.value);
        let id = parameter.name.as_str();
        let attributes = [("name", id), ("varID", id), ("units", "nd"), ("initialValue", &value)];
        d.element("variableDef", &attributes, |d| {
            let windows = coefficient.windows.join(", ");
            d.text("description", &[], &format!("derivative by {}, identified from: {windows}", parameter.term))?;
            if !parameter.standard_error.is_finite() {
                return Ok(());
            }
            d.element("uncertainty", &[("effect", "additive")], |d| {
                d.element("normalPDF", &[("numSigmas", "1")], |d| {
                    d.number("bounds", parameter.standard_error)?;
                    for later in &coefficient.parameters[index + 1..] {
                        d.empty("correlatesWith", &[("varID", &later.name)])?;
                    }
                    for (earlier, other) in coefficient.parameters[..index].iter().enumerate() {
                        let value = number(coefficient.correlation[(index, earlier)]);
                        d.empty("correlation", &[("varID", &other.name), ("corrCoef", &value)])?;
                    }
                    Ok(())
                })
            })
        })?;
    }
    Ok(())
}

/// Name of a coefficient as flight simulators have it.
pub fn signal(coefficient: Coefficient) -> &'static str {
    match coefficient {
        Coefficient::CX => "aeroBodyForceCoefficient_X",
        Coefficient::CY => "aeroBodyForceCoefficient_Y",
        Coefficient::CZ => "aeroBodyForceCoefficient_Z",
        Coefficient::Cl => "aeroBodyMomentCoefficient_Roll",
        Coefficient::Cm => "aeroBodyMomentCoefficient_Pitch",
        Coefficient::Cn => "aeroBodyMomentCoefficient_Yaw",
        Coefficient::CD => "totalCoefficientOfDrag",
        Coefficient::CL => "totalCoefficientOfLift",
    }
}

fn output_definition(
    d: &mut Document,
    model: &IdentifiedModel,
    coefficient: &IdentifiedCoefficient,
) -> Result<(), ExportError> {
    let id = coefficient.coefficient.name();
    let attributes = [("name", signal(coefficient.coefficient)), ("varID", id), ("units", "nd")];
    d.element("variableDef", &attributes, |d| {
        d.text("description", &[], &format!("coefficient {id}"))?;
        calculation(d, |d| {
            apply(d, "plus", |d| coefficient.parameters.iter().try_for_each(|p| product(d, model, &p.name, &p.term)))
        })?;
        d.empty("isOutput", &[])
    })
}

/// Derivative times term.
fn product(d: &mut Document, model: &IdentifiedModel, name: &str, term: &Term) -> Result<(), ExportError> {
    if term.is_constant() {
        return d.text("ci", &[], name);
    }
    apply(d, "times", |d| {
        d.text("ci", &[], name)?;
        term.factors().iter().try_for_each(|&(variable, power)| {
            let id = identifier(model, variable);
            if power == 1 {
                return d.text("ci", &[], &id);
            }
            apply(d, "power", |d| {
                d.text("ci", &[], &id)?;
                d.number("cn", f64::from(power))
            })
        })
    })
}

fn check_data(d: &mut Document, model: &IdentifiedModel) -> Result<(), ExportError> {
    d.element("checkData", &[], |d| {
        for (index, point) in points(model).iter().enumerate() {
            let name = if index == 0 { "middle of all ranges".to_owned() } else { format!("point {index}") };
            d.element("staticShot", &[("name", &name)], |d| {
                d.element("checkInputs", &[], |d| {
                    point
                        .inputs
                        .iter()
                        .try_for_each(|(input, value)| signal_value(d, input.signal, input.unit, *value, None))
                })?;
                d.element("checkOutputs", &[], |d| {
                    let outputs = point.outputs.iter().zip(&point.tolerances);
                    model.coefficients.iter().zip(outputs).try_for_each(|(coefficient, (value, tolerance))| {
                        signal_value(d, signal(coefficient.coefficient), "nd", *value, Some(*tolerance))
                    })
                })
            })?;
        }
        Ok(())
    })
}

fn signal_value(
    d: &mut Document,
    name: &str,
    unit: &str,
    value: f64,
    tolerance: Option<f64>,
) -> Result<(), ExportError> {
    d.element("signal", &[], |d| {
        d.text("signalName", &[], name)?;
        d.text("signalUnits", &[], unit)?;
        d.number("signalValue", value)?;
        tolerance.map_or(Ok(()), |tolerance| d.number("tol", tolerance))
    })
}
