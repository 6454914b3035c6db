use super::*;

/// Time of ten oscillations from an amplitude, s: classical Runge-Kutta steps of `I angle'' = -torque(angle)`, the crossings of zero between
/// steps along a straight line.
fn time_of_ten(inertia: f64, amplitude: f64, torque: impl Fn(f64) -> f64) -> f64 {
    let rate = |angle: f64| -torque(angle) / inertia;
    let (h, mut time, mut angle, mut speed) = (1e-4, 0.0, amplitude, 0.0);
    let mut crossings = Vec::new();
    while crossings.len() < 21 {
        let before: f64 = angle;
        let (a1, v1) = (rate(angle), speed);
        let (a2, v2) = (rate(angle + 0.5 * h * v1), speed + 0.5 * h * a1);
        let (a3, v3) = (rate(angle + 0.5 * h * v2), speed + 0.5 * h * a2);
        let (a4, v4) = (rate(angle + h * v3), speed + h * a3);
        angle += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
        speed += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        if before * angle < 0.0 {
            crossings.push(time + h * before / (before - angle));
        }
        time += h;
    }
    crossings[20] - crossings[0]
}

fn file(mass: &str, swings: &str) -> SwingFile {
    SwingFile::parse(&format!("format = \"doublet swing\"\nversion = 1\n{mass}\n{swings}")).unwrap()
}

#[test]
fn rod_about_its_end_has_a_twelfth_of_its_mass_times_its_length_squared() {
    // Textbook case: T = 2 pi sqrt(2 l / (3 g)) for l = 1 m, 1.6377 s at 9.81 m/s².
    let period_s = 2.0 * PI * (2.0f64 / (3.0 * 9.81)).sqrt();
    assert!((period_s - 1.6380).abs() < 1e-3);
    let text = format!(
        "[[swing]]\nname = \"rod\"\naxis = \"y\"\nmethod = \"compound\"\noscillations = 10\ntimes_s = [{:?}]\ntime_error_s = 0.02\n\
         pivot_to_cg_m = 0.5\npivot_error_m = 0.001\n",
        10.0 * period_s
    );
    let found = file("mass_kg = 2.0\nmass_error_kg = 0.004\ngravity_m_s2 = 9.81", &text).evaluate().unwrap();
    let row = &found.swings[0];
    assert!((row.inertia_kg_m2 - 2.0 / 12.0).abs() < 1e-12, "{}", row.inertia_kg_m2);
    // By hand: dI/dT = 2 (m l^2 / 3) / T, dI/dm = I / m, dI/dd = m g T^2 / (4 pi^2) - 2 m d = m (2/3 - 1).
    let by_hand = [
        ("period", 2.0 * (2.0 / 3.0) / period_s * 0.002),
        ("mass", 0.004 / 12.0),
        ("pivot to centre of gravity", 0.002 / 3.0),
    ];
    for (name, expected) in by_hand {
        let own = row.contributions_kg_m2[name];
        assert!((own / expected - 1.0).abs() < 1e-5, "{name}: {own} for {expected}");
    }
    let all = by_hand.iter().map(|(_, own)| own * own).sum::<f64>().sqrt();
    assert!((row.standard_error_kg_m2 / all - 1.0).abs() < 1e-5);
}

#[test]
fn periods_of_large_oscillations_by_integration_give_the_inertia_back() {
    const G: f64 = STANDARD_GRAVITY_M_S2;
    // An aircraft of 1,400 kg in a cradle, about a pivot 3.2 m above its centre of gravity, from 6 deg.
    let (mass, pivot, cradle, below, of_cradle, inertia) = (1400.0, 3.2, 120.0, 3.9, 1900.0, 3100.0);
    let moment = G * (mass * pivot + cradle * below);
    let all = inertia + mass * pivot * pivot + of_cradle;
    let compound = time_of_ten(all, 6f64.to_radians(), |angle| moment * angle.sin());
    // The same on two wires of 6 m, 2.4 m apart, from 5 deg: V = -m g sqrt(L^2 - 2 r^2 (1 - cos angle)).
    let (length, spacing, yaw) = (6.0f64, 2.4f64, 5200.0);
    let half = 0.5 * spacing;
    let bifilar = time_of_ten(yaw + 60.0, 5f64.to_radians(), |angle| {
        let height = (length * length - 2.0 * half * half * (1.0 - angle.cos())).sqrt();
        G * (mass + 40.0) * half * half * angle.sin() / height
    });
    let text = format!(
        "[[swing]]\nname = \"pitch\"\naxis = \"y\"\nmethod = \"compound\"\noscillations = 10\ntimes_s = [{compound:?}]\ntime_error_s = 0.05\n\
         amplitude_deg = 6.0\npivot_to_cg_m = 3.2\nrig_mass_kg = 120.0\nrig_pivot_to_cg_m = 3.9\nrig_inertia_kg_m2 = 1900.0\n\n\
         [[swing]]\nname = \"yaw\"\naxis = \"z\"\nmethod = \"bifilar\"\noscillations = 10\ntimes_s = [{bifilar:?}]\ntime_error_s = 0.05\n\
         amplitude_deg = 5.0\nwire_length_m = 6.0\nwire_spacing_m = 2.4\nrig_mass_kg = 40.0\nrig_inertia_kg_m2 = 60.0\n"
    );
    let found = file("mass_kg = 1400.0", &text).evaluate().unwrap();
    for (row, truth) in found.swings.iter().zip([inertia, yaw]) {
        assert!((row.inertia_kg_m2 / truth - 1.0).abs() < 2e-4, "{}: {} for {truth}", row.name, row.inertia_kg_m2);
    }
    // Without the correction the compound inertia is 1.2 % too large: the part of the pivot is taken off afterwards.
    let rough =
        file("mass_kg = 1400.0", &text.replace("amplitude_deg = 6.0", "amplitude_deg = 0.0")).evaluate().unwrap();
    assert!(rough.swings[0].inertia_kg_m2 / inertia - 1.0 > 0.005);
}

#[test]
fn tilted_axes_give_the_product_of_inertia_with_its_sign_and_the_common_error_of_the_mass() {
    // Point masses in the plane of symmetry and beside it: body coordinates, m.
    let points =
        [(300.0, [2.0, 0.0, 0.4]), (200.0, [-3.0, 0.0, -0.9]), (150.0, [0.0, 4.0, -0.3]), (150.0, [0.0, -4.0, -0.3])];
    let about = |axis: [f64; 3]| -> f64 {
        let square = |[x, y, z]: [f64; 3]| {
            let along = x * axis[0] + y * axis[1] + z * axis[2];
            x * x + y * y + z * z - along * along
        };
        points.iter().map(|(mass, place)| mass * square(*place)).sum()
    };
    let (mass, length, spacing) = (800.0, 5.0, 2.0);
    let swing = |name: &str, axis: &str, tilt: f64, truth: f64| {
        let period = (truth * 16.0 * PI * PI * length / (mass * STANDARD_GRAVITY_M_S2 * spacing * spacing)).sqrt();
        format!(
            "[[swing]]\nname = \"{name}\"\naxis = \"{axis}\"\ntilt_deg = {tilt:?}\nmethod = \"bifilar\"\noscillations = 20\n\
             times_s = [{:?}]\ntime_error_s = 0.1\nwire_length_m = {length:?}\nwire_spacing_m = {spacing:?}\n\n",
            20.0 * period
        )
    };
    let tilted = |tilt_deg: f64| {
        let tilt = tilt_deg.to_radians();
        swing(&format!("tilt {tilt_deg}"), "x", tilt_deg, about([tilt.cos(), 0.0, -tilt.sin()]))
    };
    let both = swing("pitch", "y", 0.0, about([0.0, 1.0, 0.0])) + &swing("yaw", "z", 0.0, about([0.0, 0.0, 1.0]));
    let text = tilted(0.0) + &tilted(20.0) + &tilted(-20.0) + &both;
    let found = file("mass_kg = 800.0\nmass_error_kg = 8.0", &text).evaluate().unwrap();
    let products = points.iter().map(|(mass, [x, _, z])| mass * x * z).sum::<f64>();
    let truths = [about([1.0, 0.0, 0.0]), about([0.0, 1.0, 0.0]), about([0.0, 0.0, 1.0]), products];
    assert!(products > 700.0, "{products}");
    for ((row, truth), name) in found.tensor.iter().zip(truths).zip(["Ixx", "Iyy", "Izz", "Ixz"]) {
        assert!(row.name == name && (row.value_kg_m2 - truth).abs() < 1e-6 * truths[0], "{row:?} for {truth}");
    }
    // A mass known to 1 % leaves every element known to 1 % at best, however many swings there are.
    for (row, truth) in found.tensor.iter().zip(truths).take(3) {
        assert!(row.standard_error_kg_m2 > 0.01 * truth * 0.999, "{row:?}");
    }
    assert_eq!(found.degrees_of_freedom, 1);
    // Two axes of the plane of symmetry do not give three elements.
    let two = file("mass_kg = 800.0", &(tilted(20.0) + &both)).evaluate().unwrap();
    assert!(two.tensor.is_empty() && two.swings.len() == 3);
    // Axes x and z alone give both moments without the product.
    let upright = file("mass_kg = 800.0", &(tilted(0.0) + &both)).evaluate().unwrap();
    assert_eq!(upright.tensor.iter().map(|row| row.name).collect::<Vec<_>>(), ["Ixx", "Iyy", "Izz"]);
}

#[test]
fn swings_that_cannot_be_are_refused() {
    let text = "[[swing]]\nname = \"a\"\naxis = \"y\"\nmethod = \"compound\"\noscillations = 10\ntimes_s = [20.0, 20.1]\npivot_to_cg_m = 0.5\n";
    let refused = |from: &str, to: &str| file("mass_kg = 2.0", &text.replace(from, to)).evaluate().unwrap_err();
    assert!(refused("pivot_to_cg_m = 0.5", "").contains("pivot_to_cg_m is missing"));
    assert!(refused("20.0, 20.1", "20.0").contains("no error"));
    assert!(refused("20.0, 20.1", "2.0, 2.1").contains("would be -"));
    assert!(refused("axis = \"y\"", "axis = \"y\"\ntilt_deg = 3.0").contains("axis x only"));
    let without = SwingFile::parse("format = \"doublet swing\"\nversion = 1\nmass_kg = 2.0\nswing = []").unwrap_err();
    assert!(without.contains("no [[swing]]"), "{without}");
}
