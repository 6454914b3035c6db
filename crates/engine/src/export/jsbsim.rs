//! JSBSim: the model as an `aerodynamics` file, and a minimal aircraft around it.

use doublet_core::airframe::InertiaTensor;
use doublet_core::model::{Coefficient, Term, Variable};

use super::checks::{normalisation, normalised_name};
use super::daveml::statement;
use super::xml::{Document, number};
use super::{ExportError, IdentifiedCoefficient, IdentifiedModel, MARK};

/// Metres per foot.
const M_PER_FT: f64 = 0.3048;
/// Metres per inch.
const M_PER_IN: f64 = 0.0254;
/// Kilograms per pound.
const KG_PER_LB: f64 = 0.453_592_37;
/// Newtons per pound of force.
const N_PER_LBF: f64 = 4.448_221_615_260_5;
/// Properties of JSBSim the dimensionless rates are published as.
const FOLDER: &str = "aero/identified";

/// The `aerodynamics` element. Reference area and lengths stand in it as numbers, so that it does not depend on the metrics of
/// the aircraft it is used in; the moment reference is that aircraft's AERORP.
pub fn aerodynamics(model: &IdentifiedModel) -> Result<String, ExportError> {
    check(model)?;
    let mut document = Document::new()?;
    document.comment(&format!("{MARK} {}: {}. {}", env!("CARGO_PKG_VERSION"), model.title, statement(model)))?;
    document.comment(&format!(
        "Set the location AERORP of the aircraft to the moment reference (in inches from the datum: {}). Deflections: \
         fcs/right-aileron-pos-rad positive trailing edge down, fcs/elevator-pos-rad positive trailing edge down, \
         fcs/rudder-pos-rad positive trailing edge left.",
        model.moment_reference_datum_m.map(|value| number(value / M_PER_IN)).join(", ")
    ))?;
    document.element("aerodynamics", &[], |d| {
        for variable in model.variables() {
            if let Some(normalisation) = normalisation(model, variable) {
                let description = normalised_name(model, variable).unwrap_or_default();
                rate_function(d, variable, normalisation.length_m, &description)?;
            }
        }
        for coefficient in &model.coefficients {
            coefficient_function(d, coefficient)?;
        }
        axes(d, model)
    })?;
    document.finish()
}

/// Refuses what JSBSim has no property for, and forces it could not be given.
fn check(model: &IdentifiedModel) -> Result<(), ExportError> {
    for coefficient in &model.coefficients {
        for parameter in &coefficient.parameters {
            for (variable, _) in parameter.term.factors() {
                property(*variable).map_err(|reason| ExportError::Term {
                    format: "JSBSim",
                    term: parameter.term.to_string(),
                    coefficient: coefficient.coefficient.name(),
                    reason,
                })?;
            }
        }
    }
    let has = |coefficient| model.coefficients.iter().any(|c| c.coefficient == coefficient);
    let by_lift = has(Coefficient::CD) || has(Coefficient::CL);
    let in_body_axes = has(Coefficient::CX) || has(Coefficient::CZ);
    let whole = (has(Coefficient::CX) && has(Coefficient::CZ)) || (has(Coefficient::CD) && has(Coefficient::CL));
    if by_lift && !whole || (by_lift && in_body_axes && !(has(Coefficient::CX) && has(Coefficient::CZ))) {
        let reason = "JSBSim needs the forces of the plane of symmetry as CX and CZ, or as CD and CL alone";
        return Err(ExportError::NoModel(reason.to_owned()));
    }
    Ok(())
}

/// Property of a variable and the factor to SI.
fn property(variable: Variable) -> Result<(String, f64), &'static str> {
    let (name, factor) = match variable {
        Variable::Alpha => ("aero/alpha-rad", 1.0),
        Variable::Beta => ("aero/beta-rad", 1.0),
        Variable::Aileron => ("fcs/right-aileron-pos-rad", 1.0),
        Variable::Elevator => ("fcs/elevator-pos-rad", 1.0),
        Variable::Rudder => ("fcs/rudder-pos-rad", 1.0),
        Variable::Flap => ("fcs/flap-pos-rad", 1.0),
        Variable::Airspeed => ("velocities/vt-fps", M_PER_FT),
        Variable::Altitude => ("position/h-sl-ft", M_PER_FT),
        Variable::Mach => ("velocities/mach", 1.0),
        Variable::RollRate
        | Variable::PitchRate
        | Variable::HalfPitchRate
        | Variable::YawRate
        | Variable::AlphaDot
        | Variable::BetaDot => {
            return Ok((format!("{FOLDER}/{}-hat", variable.suffix()), 1.0));
        }
        Variable::PropellerPressure => {
            return Err(
                "JSBSim has no property for the pressure rise through the propellers; leave the term out of the model",
            );
        }
        Variable::ElevatorTrim
        | Variable::Stabiliser
        | Variable::Other1
        | Variable::Other2
        | Variable::Other3
        | Variable::Other4 => {
            return Err("JSBSim has no property for trims and recorded quantities; leave the term out of the model");
        }
        Variable::ThrustCoefficient => {
            return Err("JSBSim has no property for the thrust of all engines; leave the term out of the model");
        }
    };
    Ok((name.to_owned(), factor))
}

fn rate_function(d: &mut Document, variable: Variable, length_m: f64, description: &str) -> Result<(), ExportError> {
    let rate = match variable {
        Variable::RollRate => "velocities/p-aero-rad_sec",
        Variable::PitchRate | Variable::HalfPitchRate => "velocities/q-aero-rad_sec",
        Variable::YawRate => "velocities/r-aero-rad_sec",
        Variable::AlphaDot => "aero/alphadot-rad_sec",
        _ => "aero/betadot-rad_sec",
    };
    let name = format!("{FOLDER}/{}-hat", variable.suffix());
    d.element("function", &[("name", &name)], |d| {
        d.text("description", &[], description)?;
        d.element("quotient", &[], |d| {
            product(d, |d| {
                d.text("property", &[], rate)?;
                d.number("value", length_m / M_PER_FT)
            })?;
            d.text("property", &[], "velocities/vt-fps")
        })
    })
}

fn product(
    d: &mut Document,
    content: impl FnOnce(&mut Document) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    d.element("product", &[], content)
}

fn coefficient_name(coefficient: Coefficient) -> String {
    format!("aero/coefficient/{}", coefficient.name())
}

fn coefficient_function(d: &mut Document, coefficient: &IdentifiedCoefficient) -> Result<(), ExportError> {
    let windows = coefficient.windows.join(", ");
    d.comment(&format!("{} from: {windows}", coefficient.coefficient.name()))?;
    for (index, parameter) in coefficient.parameters.iter().enumerate() {
        let earlier = coefficient.parameters[..index].iter().enumerate();
        let correlations: Vec<_> = earlier
            .map(|(other, earlier)| format!("{} {:.3}", earlier.name, coefficient.correlation[(index, other)]))
            .collect();
        let correlation = if correlations.is_empty() {
            String::new()
        } else {
            format!("; correlation with {}", correlations.join(", "))
        };
        d.comment(&format!(
            "{} = {} +- {:.3e}{correlation}",
            parameter.name,
            number(parameter.value),
            parameter.standard_error
        ))?;
    }
    let name = coefficient_name(coefficient.coefficient);
    d.element("function", &[("name", &name)], |d| {
        d.element("sum", &[], |d| {
            // JSBSim wants two operands at least.
            d.number("value", 0.0)?;
            coefficient.parameters.iter().try_for_each(|parameter| term(d, parameter.value, &parameter.term))
        })
    })
}

/// Derivative times term.
fn term(d: &mut Document, value: f64, term: &Term) -> Result<(), ExportError> {
    if term.is_constant() {
        return d.number("value", value);
    }
    product(d, |d| {
        d.number("value", value)?;
        for &(variable, power) in term.factors() {
            // Every variable was checked before the first line was written.
            let Ok((name, factor)) = property(variable) else { continue };
            if power == 1 {
                scaled(d, &name, factor)?;
            } else {
                d.element("pow", &[], |d| {
                    scaled(d, &name, factor)?;
                    d.number("value", f64::from(power))
                })?;
            }
        }
        Ok(())
    })
}

/// A property, times a factor that is not one.
fn scaled(d: &mut Document, name: &str, factor: f64) -> Result<(), ExportError> {
    if factor == 1.0 {
        return d.text("property", &[], name);
    }
    product(d, |d| {
        d.text("property", &[], name)?;
        d.number("value", factor)
    })
}

fn axes(d: &mut Document, model: &IdentifiedModel) -> Result<(), ExportError> {
    let has = |coefficient| model.coefficients.iter().any(|c| c.coefficient == coefficient);
    let area_ft2 = model.reference.area_m2 / (M_PER_FT * M_PER_FT);
    let (span_ft, chord_ft) = (model.reference.lateral_moment_length_m / M_PER_FT, model.reference.chord_m / M_PER_FT);
    let lift = !has(Coefficient::CX) && has(Coefficient::CL);
    for (axis, coefficient, length_ft) in [
        ("X", Coefficient::CX, 1.0),
        ("Y", Coefficient::CY, 1.0),
        ("Z", Coefficient::CZ, 1.0),
        ("ROLL", Coefficient::Cl, span_ft),
        ("PITCH", Coefficient::Cm, chord_ft),
        ("YAW", Coefficient::Cn, span_ft),
    ] {
        let from_lift = lift && matches!(coefficient, Coefficient::CX | Coefficient::CZ);
        if !has(coefficient) && !from_lift {
            d.comment(&format!("{} was not identified", coefficient.name()))?;
            continue;
        }
        d.element("axis", &[("name", axis)], |d| {
            let kind = if matches!(axis, "X" | "Y" | "Z") { "force" } else { "moment" };
            d.element("function", &[("name", &format!("aero/{kind}/{}", coefficient.name()))], |d| {
                product(d, |d| {
                    d.text("property", &[], "aero/qbar-psf")?;
                    d.number("value", area_ft2 * length_ft)?;
                    if from_lift {
                        body_from_lift(d, coefficient)
                    } else {
                        d.text("property", &[], &coefficient_name(coefficient))
                    }
                })
            })
        })?;
    }
    Ok(())
}

/// `CX = CL sin(alpha) - CD cos(alpha)`, `CZ = -CL cos(alpha) - CD sin(alpha)`.
fn body_from_lift(d: &mut Document, coefficient: Coefficient) -> Result<(), ExportError> {
    d.element("sum", &[], |d| match coefficient {
        Coefficient::CX => {
            times(d, 1.0, Coefficient::CL, "sin")?;
            times(d, -1.0, Coefficient::CD, "cos")
        }
        _ => {
            times(d, -1.0, Coefficient::CL, "cos")?;
            times(d, -1.0, Coefficient::CD, "sin")
        }
    })
}

fn times(d: &mut Document, sign: f64, of: Coefficient, function: &str) -> Result<(), ExportError> {
    product(d, |d| {
        d.number("value", sign)?;
        d.text("property", &[], &coefficient_name(of))?;
        d.element(function, &[], |d| d.text("property", &[], "aero/alpha-rad"))
    })
}

/// A minimal aircraft: metrics, mass and inertia as flown at the start, the aerodynamics. Engines, gear and controls are left
/// to whoever flies it.
pub fn aircraft(model: &IdentifiedModel, date: &str) -> Result<String, ExportError> {
    let mut document = Document::new()?;
    let root = [("name", model.aircraft.as_str()), ("version", "2.0"), ("release", "BETA")];
    document.element("fdm_config", &root, |d| {
        d.element("fileheader", &[], |d| {
            d.text("author", &[], crate::PROGRAM)?;
            d.text("filecreationdate", &[], date)?;
            d.text("version", &[], "1")?;
            d.text("description", &[], &format!("{}; {MARK}. {}", model.title, statement(model)))
        })?;
        metrics(d, model)?;
        mass_balance(d, model)?;
        d.empty("ground_reactions", &[])?;
        d.comment("The model holds without thrust unless stated: add the engines here.")?;
        d.empty("propulsion", &[])?;
        d.element("flight_control", &[("name", "deflections are set from outside")], |_| Ok(()))?;
        d.empty("aerodynamics", &[("file", &format!("{}_aerodynamics", model.name))])
    })?;
    document.finish()
}

fn metrics(d: &mut Document, model: &IdentifiedModel) -> Result<(), ExportError> {
    let reference = &model.reference;
    d.element("metrics", &[], |d| {
        d.text("wingarea", &[("unit", "FT2")], &number(reference.area_m2 / (M_PER_FT * M_PER_FT)))?;
        d.text("wingspan", &[("unit", "FT")], &number(reference.lateral_moment_length_m / M_PER_FT))?;
        d.text("chord", &[("unit", "FT")], &number(reference.chord_m / M_PER_FT))?;
        location(d, "AERORP", model.moment_reference_datum_m)?;
        location(d, "EYEPOINT", model.mass.cg_from_datum_m)?;
        location(d, "VRP", model.mass.cg_from_datum_m)
    })
}

/// A point: JSBSim's structural frame has the axes of the datum frame.
fn location(d: &mut Document, name: &str, [x, y, z]: [f64; 3]) -> Result<(), ExportError> {
    d.element("location", &[("name", name), ("unit", "IN")], |d| {
        d.number("x", x / M_PER_IN)?;
        d.number("y", y / M_PER_IN)?;
        d.number("z", z / M_PER_IN)
    })
}

fn mass_balance(d: &mut Document, model: &IdentifiedModel) -> Result<(), ExportError> {
    let slug_ft2 = N_PER_LBF * M_PER_FT; // 1 slug ft² = 1 lbf ft s²
    let InertiaTensor { xx, yy, zz, xz, xy, yz } = model.mass.inertia;
    // Not negated: the products themselves, not the elements of the tensor; in structural axes, whose x and z point the other way.
    d.element("mass_balance", &[("negated_crossproduct_inertia", "false")], |d| {
        for (name, value) in [("ixx", xx), ("iyy", yy), ("izz", zz), ("ixy", -xy), ("ixz", xz), ("iyz", -yz)] {
            d.text(name, &[("unit", "SLUG*FT2")], &number(value / slug_ft2))?;
        }
        d.text("emptywt", &[("unit", "LBS")], &number(model.mass.mass_kg / KG_PER_LB))?;
        location(d, "CG", model.mass.cg_from_datum_m)
    })
}
