//! Random and impossible aircraft: never a panic, never an impossible one accepted.

use doublet_core::airframe::{
    Aircraft, AircraftError, Envelope, EnvelopeRow, FixedItem, InertiaModel, InertiaTensor, Loading, OwnInertia,
    Station,
};
use proptest::prelude::*;

use super::support::shipped;

/// A number of any kind: ordinary, huge, tiny, negative, not finite.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..5000.0,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE]),
    ]
}

/// A number that no length, mass or capacity can be.
fn impossible() -> impl Strategy<Value = f64> {
    prop_oneof![-1e9..0.0, prop::sample::select(vec![0.0, 1e-300, 1e-200, 9e-5, f64::NAN, f64::INFINITY, 1e300]),]
}

/// Every number of the C337F that must be above zero, by the field its message names.
fn positive_fields(aircraft: &mut Aircraft) -> Vec<(&'static str, &mut f64)> {
    let InertiaModel::Groups { groups, .. } = &mut aircraft.inertia else { panic!("groups expected") };
    let OwnInertia::Cuboid { length_m, .. } = &mut aircraft.luggage[0].inertia else { panic!("cuboid expected") };
    let [inner, outer] = &mut aircraft.wing_panels[..] else { panic!("two panels expected") };
    let chord = aircraft.stated_mean_chord.as_mut().unwrap();
    let radii = aircraft.gyration_radii.as_mut().unwrap();
    vec![
        ("reference.area_m2", &mut aircraft.reference.area_m2),
        ("reference.span_m", &mut aircraft.reference.span_m),
        ("reference.chord_m", &mut aircraft.reference.chord_m),
        ("reference.lateral_rate_length_m", &mut aircraft.reference.lateral_rate_length_m),
        ("mean_chord.chord_m", &mut chord.chord_m),
        ("wing_panel.inner.semispan_m", &mut inner.semispan_m),
        ("wing_panel.outer.root_chord_m", &mut outer.root_chord_m),
        ("mass.mass_kg", &mut aircraft.empty.mass_kg),
        ("mass.max_takeoff_kg", aircraft.limits.max_takeoff_kg.as_mut().unwrap()),
        ("mass.max_landing_kg", aircraft.limits.max_landing_kg.as_mut().unwrap()),
        ("tank.main right.capacity_kg", &mut aircraft.tanks[0].capacity_kg),
        ("luggage.luggage.inertia.length_m", length_m),
        ("envelope[1].mass_kg", &mut aircraft.envelope.as_mut().unwrap().rows[1].mass_kg),
        ("inertia.group.wing.mass_kg", &mut groups[0].mass_kg),
        ("wheels.main_y_m", &mut aircraft.wheels.as_mut().unwrap().main_y_m),
        ("gyration_radii.x", &mut radii.x),
        ("component_fraction.wing.attributed_kg", &mut aircraft.component_fractions[0].attributed_kg),
    ]
}

/// Every coordinate of the C337F, by the field its message names.
fn coordinates(aircraft: &mut Aircraft) -> Vec<(&'static str, &mut f64)> {
    let InertiaModel::Groups { groups, .. } = &mut aircraft.inertia else { panic!("groups expected") };
    vec![
        ("mass.cg_datum_m.x", &mut aircraft.empty.cg_from_datum_m[0]),
        ("tank.main left.cg_datum_m.y", &mut aircraft.tanks[1].cg_from_datum_m[1]),
        ("seat.captain.cg_datum_m.z", &mut aircraft.seats[0].cg_from_datum_m[2]),
        ("luggage.luggage.cg_datum_m.x", &mut aircraft.luggage[0].cg_from_datum_m[0]),
        ("inertia.group.fuselage.centroid_datum_m.x", &mut groups[1].centroid_from_datum_m[0]),
        ("sensors.accelerometer_datum_m.y", &mut aircraft.sensors.accelerometer_from_datum_m.as_mut().unwrap()[1]),
        ("wheels.nose_x_m", &mut aircraft.wheels.as_mut().unwrap().nose_x_m),
        ("envelope[0].forward_x_m", &mut aircraft.envelope.as_mut().unwrap().rows[0].forward_x_m),
        ("mean_chord.leading_edge_x_m", &mut aircraft.stated_mean_chord.as_mut().unwrap().leading_edge_x_m),
    ]
}

/// Whether an error names `field`.
fn names(errors: &[AircraftError], field: &str) -> bool {
    errors.iter().any(|error| error.to_string().starts_with(&format!("{field} ")))
}

proptest! {
    #[test]
    fn a_size_or_mass_that_cannot_be_is_refused_by_name(index in 0..17_usize, value in impossible()) {
        let mut aircraft = shipped("c337f.toml");
        let mut fields = positive_fields(&mut aircraft);
        prop_assert_eq!(fields.len(), 17);
        let (name, field) = fields.remove(index);
        *field = value;
        let errors = aircraft.check().unwrap_err();
        prop_assert!(names(&errors, name), "{name} = {value} gave {errors:?}");
    }

    #[test]
    fn a_position_that_cannot_be_is_refused_by_name(
        index in 0..9_usize, value in prop::sample::select(vec![f64::NAN, f64::INFINITY, -1e6, 1e300]),
    ) {
        let mut aircraft = shipped("c337f.toml");
        let mut fields = coordinates(&mut aircraft);
        prop_assert_eq!(fields.len(), 9);
        let (name, field) = fields.remove(index);
        *field = value;
        let errors = aircraft.check().unwrap_err();
        prop_assert!(names(&errors, name), "{name} = {value} gave {errors:?}");
    }

    /// Any numbers anywhere: the check returns, and what it accepts has finite, possible mass properties.
    #[test]
    fn check_never_panics_and_what_it_accepts_is_possible(
        numbers in prop::collection::vec(any_number(), 26), tensor in [any_number(), any_number(), any_number(), any_number()],
        constant in any::<bool>(),
    ) {
        let mut aircraft = shipped("c337f.toml");
        let mut numbers = numbers.into_iter();
        for (_, field) in positive_fields(&mut aircraft) {
            // Leave most fields alone, so that some aircraft pass.
            if let Some(value) = numbers.next().filter(|value| *value as i64 % 8 == 0) { *field = value; }
        }
        for (_, field) in coordinates(&mut aircraft) {
            if let Some(value) = numbers.next().filter(|value| *value as i64 % 8 == 0) { *field = value; }
        }
        if constant {
            aircraft.inertia = InertiaModel::Constant(InertiaTensor {
                xz: tensor[3], ..InertiaTensor::diagonal(tensor[0], tensor[1], tensor[2])
            });
        }
        if aircraft.check().is_ok() {
            for loading in [Loading::default(), aircraft.standard_loading.clone()] {
                let properties = loading.mass_properties(&aircraft);
                prop_assert!(properties.mass_kg > 0.0 && properties.mass_kg.is_finite());
                prop_assert!(properties.cg_from_datum_m.iter().all(|x| x.is_finite()));
                prop_assert_eq!(properties.inertia.check(), Ok(()));
            }
        }
        prop_assert!(!doublet_core::airframe::summary(&aircraft).to_string().is_empty());
    }

    /// A tensor is accepted exactly when the eigenvalues of its matrix are positive and obey the triangle inequality to 5 %, which is
    /// what published ones differ by; that they break it at all can be told.
    #[test]
    fn constant_inertia_is_accepted_up_to_what_published_ones_break_the_triangle_by(
        a in 1.0..3000.0_f64, b in 1.0..3000.0_f64, c in 1.0..3000.0_f64, turn in [-3.0..3.0_f64, -1.5..1.5, -3.0..3.0],
    ) {
        let rotation = nalgebra::Rotation3::from_euler_angles(turn[0], turn[1], turn[2]);
        let matrix = rotation.matrix() * nalgebra::Matrix3::from_diagonal(&[a, b, c].into()) * rotation.matrix().transpose();
        let tensor = InertiaTensor {
            xx: matrix[(0, 0)], yy: matrix[(1, 1)], zz: matrix[(2, 2)],
            xy: -matrix[(0, 1)], xz: -matrix[(0, 2)], yz: -matrix[(1, 2)],
        };
        let largest = a.max(b).max(c);
        let excess = largest / (a + b + c - largest) - 1.0;
        prop_assume!(excess.abs() > 1e-6 && (excess - 0.05).abs() > 1e-6);
        prop_assert_eq!(tensor.triangle_excess().is_some(), excess > 0.0);
        let mut aircraft = shipped("citation_550_simulated.toml");
        aircraft.inertia = InertiaModel::Constant(tensor);
        prop_assert_eq!(aircraft.check().is_ok(), excess < 0.05);
    }
}

#[test]
fn contradictions_between_fields_are_refused() {
    type Spoil = fn(&mut Aircraft);
    let cases: [(&str, Spoil); 9] = [
        ("tank.main left.unusable_kg is 200", |a| a.tanks[1].unusable_kg = 200.0),
        ("tank.name is 'main right'", |a| a.tanks[1].name = "main right".into()),
        ("envelope is 1", |a| a.envelope.as_mut().unwrap().rows.truncate(1)),
        ("envelope[2].mass_kg is 100", |a| a.envelope.as_mut().unwrap().rows[2].mass_kg = 100.0),
        ("envelope[0].aft_x_m is 3", |a| a.envelope.as_mut().unwrap().rows[0].aft_x_m = 3.0),
        ("mass.max_landing_kg is 2500", |a| a.limits.max_landing_kg = Some(2500.0)),
        ("wheels.main_x_m is 1", |a| a.wheels.as_mut().unwrap().main_x_m = 1.0),
        ("loading: fuel_kg.main right is 133", |a| {
            a.standard_loading.fuel_kg.insert("main right".into(), 133.0);
        }),
        ("aircraft.name is ''", |a| a.name.clear()),
    ];
    for (message, spoil) in cases {
        let mut aircraft = shipped("c337f.toml");
        spoil(&mut aircraft);
        let errors = aircraft.check().unwrap_err();
        assert!(errors.iter().any(|error| error.to_string().starts_with(message)), "{message}: {errors:?}");
    }
}

#[test]
fn many_places_without_capacity_or_shape_are_possible() {
    let mut aircraft = shipped("citation_550_simulated.toml");
    for index in 0..50 {
        aircraft.seats.push(Station {
            name: format!("seat {index}"),
            capacity_kg: None,
            cg_from_datum_m: [index as f64 * 0.1, 0.0, 0.0],
            inertia: OwnInertia::Point,
        });
    }
    aircraft.fixed_items.push(FixedItem { name: "ballast".into(), mass_kg: 10.0, cg_from_datum_m: [0.0; 3] });
    aircraft.envelope = Some(Envelope {
        rows: vec![
            EnvelopeRow { mass_kg: 4000.0, forward_x_m: -0.5, aft_x_m: 0.5 },
            EnvelopeRow { mass_kg: 6000.0, forward_x_m: -0.5, aft_x_m: 0.5 },
        ],
    });
    assert_eq!(aircraft.check(), Ok(()));
    assert_eq!(Loading::default().mass_properties(&aircraft).mass_kg, 5010.0);
}
