//! Findings about an aircraft whose numbers do not belong together: areas, lengths, masses and inertia in different units.

use doublet_core::airframe::{MassProperties, ReferenceGeometry};
use doublet_core::message;
use doublet_core::message::Message;
use doublet_core::model::Coefficient;

use super::{Finding, Level};
use crate::session::{AircraftEdit, ChangedValue, Edit, Fix, Place};
use crate::snapshot::Snapshot;

/// Reference area over span times mean chord: 1 of a rectangle, 3/4 of a triangle, 0.5 of an ogive whose chord is that of its root.
const FILLED: [f64; 2] = [0.5, 1.25];
/// Radius of gyration in roll over half the span: 0.17 of a small unmanned aircraft with its mass in the fuselage, 0.37 with fuel at
/// the tips, 0.43 with most of its mass in the wing.
const ROLL_RADIUS: [f64; 2] = [0.15, 0.46];
/// `Izz / (Ixx + Iyy)`: 1 of a flat body, 0.63 of the stoutest fighter.
const FLATNESS: [f64; 2] = [0.55, 1.0];
/// Least radius of gyration of the mass across the plane of symmetry, `sqrt((Ixx + Izz - Iyy) / 2m)`, over half the span: 0.2 of fighters
/// with all their mass in the fuselage.
const LATERAL_RADIUS: f64 = 0.08;

const SQUARE_FOOT_M2: f64 = 0.092_903_04;

/// Takes an area that is too large for span and chord as one in square feet, to four digits; none where that does not fit them either.
fn area_in_feet(area_m2: f64, filled: f64) -> Option<Fix> {
    let [low, high] = FILLED;
    if filled <= high || !(low..=high).contains(&(filled * SQUARE_FOOT_M2)) {
        return None;
    }
    let area_m2 = (1e4 * area_m2 * SQUARE_FOOT_M2).round() / 1e4;
    let edit = AircraftEdit::set("reference area", "reference.area_m2", ChangedValue::Number(area_m2));
    Some(Fix::new(format!("use an area of {area_m2:.2} m2 (stated in square feet)"), Edit::Aircraft(edit)))
}

/// What speaks against the numbers of the aircraft of a session, with the mass of the first flight that has one.
pub(crate) fn geometry_findings(snapshot: &Snapshot) -> Vec<Finding> {
    let Some(loaded) = snapshot.aircraft.ready() else { return Vec::new() };
    findings(&"aircraft".into(), &loaded.aircraft.reference, flown(snapshot).as_ref())
}

/// What of it speaks against a coefficient: moments of inertia against the moments alone.
pub(super) fn findings_of(snapshot: &Snapshot, coefficient: Coefficient) -> Vec<Finding> {
    let Some(loaded) = snapshot.aircraft.ready() else { return Vec::new() };
    let (reference, mass) = (&loaded.aircraft.reference, flown(snapshot));
    let place = "aircraft".into();
    let mut found = units(&place, reference, mass.as_ref());
    if matches!(coefficient, Coefficient::Cl | Coefficient::Cm | Coefficient::Cn) {
        found.extend(mass.iter().flat_map(|mass| inertia(&place, reference, mass)));
    }
    found
}

/// Mass properties at the start of the first flight that has some.
fn flown(snapshot: &Snapshot) -> Option<MassProperties> {
    snapshot.flown.values().find_map(|slot| slot.ready()).map(|flown| flown.start.state.properties)
}

/// What speaks against the numbers of an aircraft, as far as they tell of each other.
pub(crate) fn findings(place: &Place, reference: &ReferenceGeometry, mass: Option<&MassProperties>) -> Vec<Finding> {
    let mut found = units(place, reference, mass);
    found.extend(mass.iter().flat_map(|mass| inertia(place, reference, mass)));
    found
}

/// Area, lengths, mass and inertia in units that do not belong together.
fn units(place: &Place, reference: &ReferenceGeometry, mass: Option<&MassProperties>) -> Vec<Finding> {
    let ReferenceGeometry { area_m2, span_m, chord_m, .. } = *reference;
    let filled = area_m2 / (span_m * chord_m);
    let outline = finding(place, filled, FILLED, |part| {
        let text =
            message!("Area {:.4} m2 is {:.3} times span {:.4} m by chord {:.4} m", area_m2, part, span_m, chord_m);
        (text, "Check the units of area, span and chord: m2 and m.")
    });
    let roll = mass.filter(|mass| mass.mass_kg > 0.0).and_then(|&MassProperties { mass_kg, inertia, .. }| {
        let radius = (inertia.xx / mass_kg).sqrt() / (0.5 * span_m);
        finding(place, radius, ROLL_RADIUS, |radius| {
            let text = message!(
                "Ixx {:.4} kg m2 at mass {:.4} kg gives a roll radius of gyration of {:.3} half-spans",
                inertia.xx,
                mass_kg,
                radius
            );
            (text, "Check the units of mass, inertia and span: kg, kg m2 and m.")
        })
    });
    let outline = outline.map(|finding| finding.with_fix(area_in_feet(area_m2, filled)));
    outline.into_iter().chain(roll).collect()
}

/// Moments of inertia that no aeroplane has: those of a body far from flat, of none at all, or of one without width.
fn inertia(place: &Place, reference: &ReferenceGeometry, mass: &MassProperties) -> Vec<Finding> {
    let MassProperties { mass_kg, inertia, .. } = *mass;
    if mass_kg <= 0.0 {
        return Vec::new();
    }
    let flatness = finding(place, inertia.zz / (inertia.xx + inertia.yy), FLATNESS, |part| {
        let text = message!("Izz is {:.3} times Ixx + Iyy", part);
        (text, "Check the moments of inertia.")
    });
    let caution = |text: Message, figure: f64, limit: f64| {
        let finding = Finding::new(Level::Caution, "aircraft", place, text).with_figure(figure, limit);
        finding.with_setting("Airframe", "aircraft")
    };
    let triangle = inertia.triangle_excess().filter(|_| flatness.is_none()).map(|excess| {
        let percent = 100.0 * excess;
        let text = message!(
            "The largest principal inertia exceeds the sum of the others by {:.1} %, which is impossible.",
            percent
        );
        caution(text, excess, 0.0).with_fix_text("Check the loading that the published moments belong to.")
    });
    let width = 0.5 * (inertia.xx + inertia.zz - inertia.yy) / mass_kg;
    let radius = width.max(0.0).sqrt() / (0.5 * reference.span_m);
    let lateral = (radius < LATERAL_RADIUS && flatness.is_none() && triangle.is_none()).then(|| {
        let text = message!(
            "Ixx + Izz - Iyy gives a lateral radius of gyration of {:.3} half-spans (limit {}).",
            radius,
            LATERAL_RADIUS
        );
        caution(text, radius, LATERAL_RADIUS).with_fix_text("Check the moments of inertia, Iyy above all.")
    });
    [flatness, triangle, lateral].into_iter().flatten().collect()
}

/// How many times beyond a limit a figure is bad: a unit is wrong then.
const BAD_TIMES: f64 = 1.25;

/// A finding where `figure` is outside `limits`, with the text and the fix of `say`.
fn finding(
    place: &Place,
    figure: f64,
    limits: [f64; 2],
    say: impl Fn(f64) -> (Message, &'static str),
) -> Option<Finding> {
    let [low, high] = limits;
    if (low..=high).contains(&figure) {
        return None;
    }
    let (text, fix_text) = say(figure);
    let (limit, times) = if figure > high { (high, figure / high) } else { (low, low / figure) };
    let level = if times > BAD_TIMES { Level::Bad } else { Level::Caution };
    let text = message!("{} (limits {} to {}).", text, low, high);
    let finding = Finding::new(level, "aircraft", place, text).with_figure(figure, limit);
    Some(finding.with_fix_text(fix_text).with_setting("Airframe", "aircraft"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A light single: m2, m, kg, kg m2.
    const SINGLE: [f64; 7] = [16.17, 10.97, 1.494, 1125.0, 2839.0, 2040.0, 4269.0];

    fn found(numbers: [f64; 7]) -> Vec<String> {
        let [area_m2, span_m, chord_m, mass_kg, xx, yy, zz] = numbers;
        let reference = ReferenceGeometry::conventional(area_m2, span_m, chord_m);
        let mut mass = MassProperties { mass_kg, ..MassProperties::default() };
        (mass.inertia.xx, mass.inertia.yy, mass.inertia.zz) = (xx, yy, zz);
        findings(&"aircraft".into(), &reference, Some(&mass)).iter().map(|finding| finding.text.to_string()).collect()
    }

    #[test]
    fn numbers_in_different_units_are_told_and_consistent_ones_are_not() {
        assert_eq!(found(SINGLE), [""; 0]);
        // Iyy close to Ixx + Izz: mass in the plane of symmetry alone.
        let narrow = [358.0, 25.55, 27.66, 185_170.0, 3_062_490.0, 22_904_900.0, 19_865_300.0];
        assert!(found(narrow)[0].contains("lateral radius of gyration of 0.019"), "{:?}", found(narrow));
        let cases: [(usize, f64, &str); 6] = [
            (0, 10.764, "Area 174.0539 m2 is 10.620 times"),
            (1, 3.2808, "Area 16.1700 m2 is 0.301 times"),
            (2, 3.2808, "Area 16.1700 m2 is 0.301 times"),
            (3, 1.0 / 14.594, "Ixx 2839.0000 kg m2 at mass 77.0865 kg"),
            (4, 3.0, "Ixx 8517.0000 kg m2"),
            (6, 0.5, "Izz is 0.437 times"),
        ];
        for (index, factor, text) in cases {
            let mut numbers = SINGLE;
            numbers[index] *= factor;
            let texts = found(numbers);
            assert!(texts.iter().any(|found| found.starts_with(text)), "{index}: {texts:?}");
        }
        assert_eq!(area_in_feet(SINGLE[0], SINGLE[0] / (SINGLE[1] * SINGLE[2])), None);
        let fix = area_in_feet(SINGLE[0] / SQUARE_FOOT_M2, 10.62).unwrap();
        let edit = AircraftEdit::set("reference area", "reference.area_m2", ChangedValue::Number(SINGLE[0]));
        assert_eq!(fix.edits, [Edit::Aircraft(edit)]);
        // All lengths in feet, as areas and lengths among themselves agree: the mass tells.
        let [area, span, chord, rest @ ..] = SINGLE;
        let feet = [area * 10.764, span * 3.2808, chord * 3.2808, rest[0], rest[1], rest[2], rest[3]];
        assert!(found(feet)[0].contains("roll radius of gyration of 0.088"), "{:?}", found(feet));
    }
}
