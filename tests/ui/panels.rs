//! Panels on the small flight and the shipped one: the numbers behind what is drawn.

use doublet::command::{EditCommand, UiCommand};
use doublet::panels::Pane;
use doublet::ui_state::Scope;
use doublet_core::estimate::Origin;
use doublet_core::model::{Axes, Coefficient, Term};
use doublet_core::quantity::Role;
use doublet_core::reconstruct::consistency::WORTH_CHANGING;
use doublet_core::reconstruct::{Method, State};
use doublet_engine::session::{self, Edit, FilterEdit, ModelEdit, Surface};
use doublet_engine::study::LagKind;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::workbench::Bench;
use crate::{click, copied_data, drag, picture, secondary_click};

/// Rounding of sums over a thousand samples, relative.
const ROUNDING: f64 = 1e-8;

#[test]
fn effects_of_terms_are_those_of_fits_with_and_without_them() {
    let mut bench = Bench::open();
    bench.show(Pane::Model);
    bench.push("Cm");
    picture(&mut bench.harness, "model_effects");
    let details = bench.snapshot().details.ready().expect("the model was looked at").clone();
    let study = details.model.iter().find(|study| study.coefficient == Coefficient::Cm).expect("Cm is modelled");
    let effects = study.study.as_ref().expect("it is studied");
    let full = bench.cm();
    assert!((effects.r_squared / full.quality.r_squared - 1.0).abs() < ROUNDING);
    // Without alpha, and with its rate: the same windows fitted anew.
    let effect = |name: &str| effects.terms.iter().find(|term| term.name == name).expect("the term is studied");
    let square = |fit: &doublet_core::estimate::Fit| fit.residuals.iter().map(|v| v * v).sum::<f64>();
    for (name, term, on) in [("Cm_alpha", "alpha", false), ("Cm_alpha_dot", "alpha_dot*c/V", true)] {
        let term = Term::parse(term).expect("it is a term");
        let edit = Edit::Model(ModelEdit::SetTerm { coefficient: Coefficient::Cm, term, on });
        let other = bench.alone(|session| *session = edit.apply(session).expect("the edit fits"));
        let other = other.pooled.ready().expect("it is estimated").fits[0].fit.clone().expect("Cm has a fit");
        let change = other.quality.r_squared - full.quality.r_squared;
        assert!((effect(name).r_squared_change - change).abs() < ROUNDING, "{name}: {change}");
        let (less, more) = if on { (&full, &other) } else { (&other, &full) };
        let partial_f = (square(less) - square(more)) / more.residual_std.powi(2);
        assert!((effect(name).partial_f / partial_f - 1.0).abs() < 1e-6, "{name}: {partial_f}");
        assert_eq!(effect(name).in_model, !on);
    }
    assert!(!effect("Cm_beta").informative, "sideslip is zero all the time");
    assert!(
        bench.harness.query_all_by_label_contains("collinear with the other terms").next().is_some(),
        "the table says so"
    );
    bench.choose("effect of Cm alpha_dot*c/V");
    assert!(bench.cm().parameter("Cm_alpha_dot").is_some(), "a tick of the table is a tick of the model");
}

#[test]
fn filters_are_compared_by_the_paths_each_gives_alone() {
    let mut bench = Bench::open();
    bench.show(Pane::Reconstruction);
    bench.choose("Attitude");
    bench.choose("compare filters");
    picture(&mut bench.harness, "filters_compared");
    let details = bench.snapshot().details.ready().expect("the manoeuvre was looked at").clone();
    let window = details.window.as_ref().expect("a manoeuvre is chosen");
    let [plain, iterated] = window.filters.as_ref().expect("it was asked for").as_ref().expect("both run");
    for (path, method) in [(plain, Method::Ekf), (iterated, Method::Iekf { max_iterations: 10, tolerance: 1e-3 })] {
        let edit = Edit::Filter(FilterEdit::Method(method));
        let other = bench.alone(|session| *session = edit.apply(session).expect("the edit fits"));
        let other = other.windows["first"].path.ready().expect("the path is there").clone();
        for state in [State::PitchAngle, State::VelocityW] {
            assert_eq!(path.reconstruction.states[state as usize], other.reconstruction.states[state as usize]);
        }
    }
    // The table of biases: means of the last second.
    bench.choose("Table");
    let path = bench.snapshot().windows["first"].path.ready().expect("the path is there").clone();
    let time_s = &path.reconstruction.time_s;
    let end_s = time_s[time_s.len() - 1];
    let wind = &path.reconstruction.states[State::WindNorth as usize];
    let last: Vec<f64> = time_s.iter().zip(wind).filter(|(t, _)| **t > end_s - 1.0).map(|(_, value)| *value).collect();
    let mean = last.iter().sum::<f64>() / last.len() as f64;
    assert!((details.biases.rows[0].1[0] - mean).abs() <= ROUNDING * mean.abs(), "{mean}");
}

#[test]
fn contributions_add_up_to_the_fit_and_residuals_are_tested() {
    let mut bench = Bench::open();
    bench.show(Pane::Fits);
    bench.choose("Contributions");
    picture(&mut bench.harness, "contributions");
    let details = bench.snapshot().details.ready().expect("the manoeuvre was looked at").clone();
    let window = details.window.as_ref().expect("a manoeuvre is chosen");
    let fits = bench.snapshot().windows["first"].fits.ready().expect("it is fitted").clone();
    let series = fits.fits[0].series.as_ref().expect("it is fitted");
    let (fitted, residual) = (series.fitted(), &series.residual);
    for at in [0, 100, 400] {
        let sum: f64 = window.contributions[0].terms.iter().map(|(_, part)| part.values[at]).sum();
        assert!((sum - fitted.values[at]).abs() < ROUNDING, "{sum}");
    }
    bench.choose("Whiteness");
    picture(&mut bench.harness, "whiteness");
    let study = &window.residuals[0];
    let mean = residual.values.iter().sum::<f64>() / residual.values.len() as f64;
    let product = |lag: usize| -> f64 {
        let late = residual.values.iter().skip(lag);
        residual.values.iter().zip(late).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    assert!((study.whiteness.autocorrelation[7] - product(7) / product(0)).abs() < 1e-6);
    assert_eq!(study.histogram.counts.iter().sum::<usize>(), residual.values.len());
    assert!(bench.harness.query_by_label("histogram of the residual").is_some());
}

#[test]
fn every_kind_of_input_has_the_mean_of_its_windows_in_the_shipped_flight() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Derivatives);
    for (scope, name) in [(Scope::All, "derivatives"), (Scope::Over, "over_windows"), (Scope::Intervals, "intervals")] {
        bench.harness.state_mut().state.selection.scope = scope;
        bench.settle();
        picture(&mut bench.harness, name);
    }
    let details = bench.snapshot().details.ready().expect("the manoeuvres were looked at").clone();
    assert_eq!(details.kinds.iter().map(|kind| kind.kind.as_str()).collect::<Vec<_>>(), ["", "3-2-1-1", "doublet"]);
    for kind in &details.kinds[1..] {
        let found = kind.parameters.iter().find(|parameter| parameter.name == "Cm_q").expect("Cm is modelled");
        let windows = bench
            .session()
            .windows
            .iter()
            .filter(|window| window.role == session::WindowRole::Identification && window.kind == kind.kind);
        let estimates: Vec<f64> = windows
            .filter_map(|window| {
                let fits = bench.snapshot().windows[&window.name].fits.ready()?.clone();
                fits.fits.iter().find_map(|fit| Some(fit.fit.as_ref().ok()?.parameter("Cm_q")?.0))
            })
            .collect();
        assert!(estimates.len() > 1 && estimates.len() == found.fits);
        let mean = estimates.iter().sum::<f64>() / estimates.len() as f64;
        assert!((found.estimate[0] - mean).abs() < 1e-12, "{}: {mean}", kind.kind);
    }
    // Pictures of the wide panels.
    for (pane, name) in [(Pane::GroundTrack, "ground_track"), (Pane::Model, "model_shipped"), (Pane::Log, "log")] {
        bench.show(pane);
        picture(&mut bench.harness, name);
    }
}

#[test]
fn derivatives_from_elsewhere_are_marked_beside_the_estimates() {
    let mut bench = Bench::open();
    let table = "derivative,estimate,standard_error\nCm_alpha,-0.75,0.02\n";
    std::fs::write(bench.folder.path().join("handbook.csv"), table).expect("a file can be written");
    bench.show(Pane::Derivatives);
    bench.choose("Intervals");
    bench.harness.state_mut().state.selection.derivative = Some("Cm_alpha".to_owned());
    click(&mut bench.harness, "Add reference…", 3);
    click(&mut bench.harness, "handbook.csv", 2);
    bench.choose("Open");
    picture(&mut bench.harness, "references");
    let plot = bench.harness.get_by_label("estimates of every manoeuvre").rect();
    let text = copied_data(&mut bench.harness, plot.center());
    let at =
        text.lines().next().and_then(|head| head.split(',').position(|name| name == "handbook")).expect("a column");
    let marked = text.lines().skip(1).filter_map(|line| line.split(',').nth(at)).find(|cell| !cell.is_empty());
    assert_eq!(marked, Some("-0.75"), "{text}");
    bench.choose("Remove references");
    assert!(bench.harness.state().references.is_empty());
}

#[test]
fn sensitivity_to_inertia_is_that_of_the_moment_itself() {
    let mut bench = Bench::open();
    bench.show(Pane::Sensitivity);
    bench.push("Compute sensitivity");
    picture(&mut bench.harness, "sensitivity");
    let study = bench.snapshot().studies.sensitivity.ready().expect("it was asked for").clone();
    let table = study.tables.iter().find(|table| table.step.quantity.name() == "Iyy").expect("inertia is varied");
    // The flight has no roll or yaw: Cm is Iyy q_dot over a constant, so five per cent of Iyy are five per cent of it.
    for partial in &table.partials {
        assert!((partial.relative_percent.abs() - 5.0).abs() < 1e-6, "{partial:?}");
    }
    assert!(bench.harness.query_by_label("tornado of sensitivity").is_some());
    let shown = bench.harness.get_all_by_role(egui::accesskit::Role::ComboBox);
    let shown: Vec<String> = shown.filter_map(|node| node.accesskit_node().value()).collect();
    assert!(shown.contains(&doublet::notation::derivative("Cm_alpha")), "a slope first, no constant: {shown:?}");
}

#[test]
fn tornado_has_its_widest_bar_at_the_top() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Sensitivity);
    bench.push("Compute sensitivity");
    let chart = bench.harness.get_by_label("tornado of sensitivity").rect();
    let text = copied_data(&mut bench.harness, chart.center());
    // A bar of "lower" has four corners around its place, 0.2 above it; its end is the change. The widest lies at 0, the others below.
    let corner = |line: &str| {
        let mut cells = line.split(',').map(|cell| cell.parse::<f64>().ok());
        Some((cells.next()??, cells.next()??))
    };
    let mut widths: Vec<(f64, f64)> = Vec::new();
    for (change, place) in text.lines().skip(1).filter_map(corner).filter(|(change, _)| *change != 0.0) {
        let place = (place - 0.2).round();
        match widths.iter_mut().find(|(at, _)| *at == place) {
            Some((_, width)) => *width = width.max(change.abs()),
            None => widths.push((place, change.abs())),
        }
    }
    widths.sort_by(|one, other| other.0.total_cmp(&one.0));
    assert!(widths.len() > 1 && widths[0].0 == 0.0, "{text}");
    assert!(widths.windows(2).all(|pair| pair[0].1 >= pair[1].1 - 0.05), "the widest first: {widths:?}");
}

#[test]
fn frequency_responses_are_drawn_with_their_equivalent_systems() {
    let mut bench = Bench::shipped();
    bench.request(UiCommand::View(doublet::command::ViewCommand::Step(doublet::step::Step::Results)));
    bench.show(Pane::Responses);
    bench.push("Compute frequency responses");
    picture(&mut bench.harness, "responses");
    let study = bench.snapshot().studies.responses.ready().expect("they were asked for").clone();
    let surfaces: Vec<Surface> = study.surfaces.iter().map(|found| found.surface).collect();
    assert_eq!(surfaces, Surface::ALL);
    for found in &study.surfaces {
        let (response, system) = (found.response.as_ref().unwrap(), found.system.as_ref().unwrap());
        let coherent = response.responses[0].points.iter().filter(|point| point.coherence > 0.8).count();
        assert!(coherent > 25, "{:?}: {coherent}", found.surface);
        // Above its modes the identified model's own response lies on the measured one.
        let near = response.responses[0].points.iter().zip(&found.model).find(|(point, _)| point.omega_rad_s > 4.0);
        let (point, own) = near.expect("the model has a response");
        let apart = 20.0 * (own.norm() / point.response.norm()).log10();
        assert!(apart.abs() < 3.0, "{:?}: {apart} dB", found.surface);
        // A positive deflection gives a negative rate.
        assert!(system.fit.model.gain < 0.0, "{:?}", found.surface);
    }
    bench.harness.set_size(egui::vec2(1500.0, 1400.0));
    bench.settle();
    assert!(bench.harness.query_by_label("1/Tθ₂").is_some(), "the equivalent system of the elevator");
    // Its levels by the standard that is chosen: the delay has limits in MIL-STD-1797A alone, which is shown beside the other.
    let delay_level = || bench.harness.query_by_label("equivalent delay").is_some();
    assert!(delay_level() && bench.harness.query_by_label_contains("MIL-F-8785C, class I by").is_some());
    bench.choose_of("standard", "MIL-STD-1797A");
    assert!(bench.harness.query_by_label_contains("MIL-STD-1797A, class I by").is_some());
    picture(&mut bench.harness, "response_levels");
    bench.choose("aileron");
    assert!(bench.harness.query_by_label("1/Tθ₂").is_none(), "that of the aileron in its place");
    assert!(bench.harness.query_by_label("ζ_z1").is_some(), "its form holds the Dutch roll");
}

#[test]
fn delay_the_fit_finds_is_taken_by_a_click_and_undone() {
    let mut bench = Bench::open();
    bench.show(Pane::Model);
    click(&mut bench.harness, "Axes, reference, thrust and lags", 20);
    // The deflection was recorded when it acted: a delay is wrong, and the fit finds it back.
    bench.enter("elevator delay", "40");
    bench.settle();
    bench.push("Find lags of the controls");
    picture(&mut bench.harness, "model_lags");
    let lags = bench.snapshot().studies.lags.ready().expect("they were asked for").clone();
    let (found, error) = lags.get(Surface::Elevator, LagKind::Delay).unwrap().found_s().unwrap();
    assert!(found.abs() < 1e-3 && error < 1e-3, "{found} {error}");
    // A first-order lag on top of the delay only makes it worse: it ends at zero, which is no value to take.
    assert!(lags.get(Surface::Elevator, LagKind::FirstOrder).unwrap().found_s().is_err());
    bench.choose(&format!("{:.1} ± {:.1} ms", 1e3 * found, 1e3 * error));
    assert_eq!(bench.session().preparation.control_lags.get(Surface::Elevator).delay_s, found);
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.session().preparation.control_lags.get(Surface::Elevator).delay_s, 0.04);
}

#[test]
fn ground_track_is_drawn_from_the_position_and_its_data_can_be_copied() {
    let mut bench = Bench::shipped();
    bench.show(Pane::GroundTrack);
    let plot = bench.harness.get_by_label("ground track").rect();
    let text = copied_data(&mut bench.harness, plot.center());
    assert!(text.starts_with("east [km],track"), "{}", text.lines().next().unwrap_or_default());
    let flight = bench.snapshot().flights.values().next().and_then(|slot| slot.ready()).expect("it is read").clone();
    // The flight has no position: the track is the integral of its ground velocity.
    let velocity = |role| flight.recording.role(role).expect("it is recorded").series.clone();
    let [north, east] = [Role::VelocityNorth, Role::VelocityEast].map(velocity);
    let integral = |series: &doublet_core::series::Series| -> f64 {
        let steps = series.time_s.windows(2).zip(series.values.windows(2));
        steps.map(|(t, v)| (t[1] - t[0]) * 0.5 * (v[0] + v[1])).filter(|step| step.is_finite()).sum()
    };
    let last: Vec<f64> = text
        .lines()
        .rfind(|line| line.split(',').nth(1).is_some_and(|cell| !cell.is_empty()))
        .map(|line| line.split(',').filter_map(|cell| cell.parse().ok()).collect())
        .expect("a row");
    // Every few samples are drawn: the last of them is within some seconds of the end, where the aircraft stands.
    let off_m = |km: f64, series| (1e3 * km - integral(series)).abs();
    assert!(off_m(last[0], &east) < 100.0 && off_m(last[1], &north) < 100.0, "{last:?}");
    picture(&mut bench.harness, "ground_track");
}

#[test]
fn change_of_loading_lists_the_change_of_every_derivative() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Loading);
    picture(&mut bench.harness, "envelope");
    let cx = |bench: &Bench<'_>| {
        let pooled = bench.snapshot().pooled.ready().expect("the estimate is up to date").clone();
        pooled.fits[0].fit.clone().expect("CX is estimated")
    };
    let before = cx(&bench);
    let slider = bench.harness.get_by_role_and_label(egui::accesskit::Role::Slider, "Seats passenger right").rect();
    drag(&mut bench.harness, slider.center(), slider.left_center() + egui::vec2(2.0, 0.0), 4);
    bench.settle();
    bench.choose("Change of derivatives");
    picture(&mut bench.harness, "loading_changes");
    let now = cx(&bench);
    let slope = |fit: &doublet_core::estimate::Fit| fit.parameter("CX_alpha").expect("it is in the model").0;
    let part = 100.0 * (slope(&now) - slope(&before)) / slope(&before).abs();
    let shown = doublet::notation::fixed(part, 2);
    assert!(bench.harness.query_all_by_label(&shown).next().is_some(), "{shown} is in the table");
}

#[test]
fn window_times_are_shown_and_typed_to_the_millisecond() {
    let mut bench = Bench::open();
    bench.show(Pane::Manoeuvres);
    bench.enter("first start", "5.125");
    assert_eq!(bench.session().windows[0].window.start_s, 5.125);
    bench.enter("first end", "24.875");
    let path = bench.snapshot().windows["first"].path.ready().expect("the path is up to date").clone();
    let time_s = &path.reconstruction.time_s;
    assert!(time_s[0] >= 5.125 && time_s[time_s.len() - 1] <= 24.875, "{:?}", time_s.last());
}

#[test]
fn panels_say_what_they_wait_for_while_the_first_run_computes() {
    let mut harness = crate::builder(1280.0, 720.0).build_eframe(|cc| {
        let document = doublet::app::Document::open_demo().expect("a session is shipped");
        crate::overview(doublet::app::Workbench::new(cc, document).expect("a thread starts"))
    });
    harness.run_steps(3);
    assert!(harness.query_by_label("Waiting for the recording").is_some());
    picture(&mut harness, "first_run");
}

#[test]
fn derivative_table_fits_a_small_window() {
    let mut bench = Bench::shipped_in(1280.0, 720.0);
    bench.show(Pane::Derivatives);
    let right = bench.harness.get_by_label("t").rect().right();
    picture(&mut bench.harness, "small_window");
    assert!(right <= 1280.0, "the last column ends at {right}");
}

#[test]
fn noise_panel_tells_what_the_window_does_not_and_marks_what_differs_from_the_proposal() {
    let mut bench = Bench::open();
    bench.show(Pane::Noise);
    let path = bench.snapshot().windows["first"].path.ready().expect("the path is there").clone();
    let text = format!(
        "first: observability rank {} of {}",
        path.assessment().observability.rank,
        path.assessment().observability.open
    );
    assert!(bench.harness.query_by_label(&text).is_some(), "{text}");
    // Wind is known beforehand in this session: 15 of the 18 states are open.
    assert_eq!(path.assessment().observability.open, 15);
    let hidden = path.assessment().observability.hidden.iter().any(|state| State::ALL[15..].contains(state));
    assert!(!hidden, "what is known is not called hidden");
    let consistency = path.assessment().consistency.as_ref().expect("innovations are there");
    for channel in &consistency.channels {
        let odd = channel.has_offset() || channel.is_correlated();
        let fits = (1.0 / WORTH_CHANGING..=WORTH_CHANGING).contains(&channel.deviation_ratio);
        assert_eq!(channel.is_consistent(), fits && !odd, "{}", channel.deviation_ratio);
        let mark = if odd { " ∿" } else { "" };
        let shown = format!("×{}{mark}", doublet::notation::fixed(channel.deviation_ratio, 2));
        assert!(bench.harness.query_all_by_label(&shown).next().is_some(), "{shown}");
    }
}

#[test]
fn cross_plot_draws_two_channels_over_the_chosen_window() {
    let mut bench = Bench::open();
    bench.show(Pane::CrossPlot);
    let chart = bench.harness.get_by_role_and_label(egui::accesskit::Role::Image, "cross plot").rect();
    let text = copied_data(&mut bench.harness, chart.center());
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').filter_map(|cell| cell.parse().ok()).collect()).collect();
    // The window is 20 s long, at 0.02 s, both ends included.
    let rows: Vec<_> = rows.into_iter().filter(|row| row.len() > 1).collect();
    assert_eq!(rows.len() % 1001, 0, "{}", rows.len());
    let (least, most) =
        rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), row| (l.min(row[0]), m.max(row[0])));
    // alpha = 0.06 rad plus sines of 0.03 and 0.015 rad, shown in degrees.
    assert!(least > 0.859 && most < 6.017 && most - least > 4.0, "{least} to {most}");
}

#[test]
fn derivative_is_fixed_in_the_menu_of_its_tick_and_marked_in_the_table() {
    let mut bench = Bench::open();
    bench.show(Pane::Model);
    let place = bench.harness.get_by_label("Cm qc/V").rect().center();
    secondary_click(&mut bench.harness, place);
    picture(&mut bench.harness, "model_known_menu");
    bench.choose("Fixed");
    let fit = bench.cm();
    let at = fit.names.iter().position(|name| name == "Cm_q").expect("it stays in the model");
    assert_eq!((fit.origins[at], fit.standard_errors[at]), (Origin::Fixed, 0.0));
    assert!(bench.harness.query_by_label("value of Cm_q").is_some(), "the menu stays for the number");
    picture(&mut bench.harness, "model_fixed");
    bench.enter("value of Cm_q", "-12");
    bench.settle();
    assert_eq!(bench.cm().parameter("Cm_q"), Some((-12.0, 0.0)));
    bench.harness.key_press(egui::Key::Escape);
    bench.settle();
    bench.show(Pane::Derivatives);
    assert!(bench.harness.query_all_by_label("fixed").next().is_some(), "the table says so");
    picture(&mut bench.harness, "derivatives_fixed");
    bench.show(Pane::Model);
    click(&mut bench.harness, "Axes, reference, thrust and lags", 20);
    bench.choose("Stability");
    picture(&mut bench.harness, "model_coefficients");
    let session = bench.session();
    assert_eq!(session.preparation.axes, Axes::Stability);
    assert_eq!(session.estimation.constraints.len(), 1);
}

#[test]
fn modes_say_in_one_line_what_the_model_lacks() {
    let mut bench = Bench::open();
    bench.show(Pane::Dynamics);
    picture(&mut bench.harness, "dynamics");
    // The flight's model is of the pitching moment alone: nothing carries the aircraft.
    let error = bench.snapshot().inquiries.dynamics.error().map(str::to_owned).expect("it cannot be trimmed");
    assert!(error.contains("no derivatives of CX, CZ") && !error.contains('\n'), "{error}");
    assert!(bench.harness.query_all_by_label_contains("no derivatives of CX, CZ").next().is_some());
}
