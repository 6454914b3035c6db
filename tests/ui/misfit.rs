//! Where a fit fails and what moves with it, curves seen otherwise, the list of edits, one advice on the noise.

use std::time::{Duration, Instant};

use doublet::command::{EditCommand, UiCommand, ViewCommand};
use doublet::panels::Pane;
use doublet_core::prep::spectrum;
use doublet_core::reconstruct::Measurement;
use doublet_engine::stage::NoiseStep;
use doublet_engine::trace::TraceAnalysis;
use egui::{ThemePreference, vec2};
use egui_kittest::kittest::Queryable;

use crate::workbench::Bench;
use crate::{painted, picture, secondary_click};

/// Longest wait for a curve.
const PATIENCE: Duration = Duration::from_secs(20);

/// Pictures of what is on screen at both sizes, dark and light; no text is cut in any, where no window lies over others.
fn pictures(bench: &mut Bench<'_>, name: &str, windows: bool) {
    for (theme, word) in [(ThemePreference::Dark, "dark"), (ThemePreference::Light, "light")] {
        for [width, height] in [[1280.0, 720.0], [1600.0, 1000.0]] {
            bench.harness.set_size(vec2(width, height));
            bench.harness.state_mut().request(UiCommand::View(ViewCommand::Appearance(theme)));
            bench.harness.run_steps(4);
            picture(&mut bench.harness, &format!("{name}_{word}_{width}"));
            if !windows {
                assert_eq!(painted::faults(bench), [""; 0], "{name} {word} {width}");
            }
        }
    }
    bench.harness.set_size(vec2(1500.0, 950.0));
    bench.harness.state_mut().request(UiCommand::View(ViewCommand::Appearance(ThemePreference::Dark)));
    bench.harness.run_steps(4);
}

#[test]
fn a_fit_has_its_band_and_a_click_lists_the_channels_that_move_with_its_residual() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Fits);
    let details =
        bench.snapshot().details.ready().expect("it was looked at").window.clone().expect("a manoeuvre is chosen");
    let fits = bench.snapshot().windows[&details.name].fits.ready().expect("it is fitted").clone();
    for (coefficient, half) in &details.bands {
        let fit = fits.fits.iter().find(|fit| fit.coefficient == *coefficient).expect("it is fitted");
        let residual = &fit.series.as_ref().expect("it has residuals").residual;
        let inside = residual.values.iter().zip(half.iter()).filter(|(v, half)| v.abs() < 2.0 * **half).count();
        let part = inside as f64 / residual.values.len() as f64;
        assert!((0.9..0.99).contains(&part), "{coefficient:?}: the 95 % band holds {part}");
    }
    assert!(details.bands.len() >= 2);
    for name in ["spectrum of the residual", "autocorrelation of the residual"] {
        assert!(bench.harness.query_by_label(name).is_some(), "{name} stands beside the fits");
    }
    let legend = bench.harness.get_all_by_label("legend fit ± 95 % band").next().expect("it is named").rect();
    let at = legend.left_bottom() + vec2(160.0, 70.0);
    bench.harness.hover_at(at);
    bench.harness.run_steps(2);
    crate::drag(&mut bench.harness, at, at, 0);
    bench.settle();
    let details =
        bench.snapshot().details.ready().expect("it was looked at").window.clone().expect("a manoeuvre is chosen");
    let found = details.misfit.expect("it was asked for").expect("it is found");
    assert!(found.part.contains(found.place.time_s) && found.bound > 0.0 && found.bound < 1.0);
    assert!(found.channels.len() > 5 && found.channels.windows(2).all(|pair| pair[0].share >= pair[1].share));
    let first = &found.channels[0];
    let listed = format!("{} coherent {:.0} %", first.name, 100.0 * first.share);
    assert!(bench.harness.query_by_label(&listed).is_some(), "the list begins with {listed}");
    assert!(bench.harness.query_all_by_label_contains("Correlated with Δ").next().is_some());
    pictures(&mut bench, "fit", false);
}

/// Opens the menu of the plot at `at` and asks for an analysis.
fn analyse(bench: &mut Bench<'_>, at: egui::Pos2, entries: &[&str]) {
    secondary_click(&mut bench.harness, at);
    bench.harness.get_by_label_contains("Analyse").click();
    bench.harness.run_steps(4);
    for entry in entries {
        let exact = bench.harness.query_all_by_label(entry).last();
        let node = exact.or_else(|| bench.harness.query_all_by_label_contains(entry).last());
        node.expect("it is in the menu").click();
        bench.harness.run_steps(4);
    }
    let started = Instant::now();
    while bench.harness.state().is_analysing() {
        assert!(started.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
        bench.harness.step();
    }
    bench.harness.run_steps(3);
}

#[test]
fn a_curve_is_seen_as_spectrum_spectrogram_derivative_and_over_another() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Fits);
    let label = bench.harness.get_all_by_label("legend fit ± 95 % band").next().expect("it is named").rect();
    let at = label.left_bottom() + vec2(160.0, 70.0);
    analyse(&mut bench, at, &["observed", "Spectrum of the visible span"]);
    let app = bench.harness.state();
    let (request, seen) = app.analyses().last().expect("it is there");
    let TraceAnalysis::Spectrum(found) = seen else { panic!("a spectrum") };
    assert_eq!(Some(found), spectrum(&request.series.within(request.range)).as_ref());
    let whole = app.state.window_time.range();
    assert_eq!(request.range, whole, "what is on screen");
    assert!(bench.harness.query_all_by_label_contains("Highest at").next().is_some());
    analyse(&mut bench, at, &["observed", "Spectrogram"]);
    assert!(bench.harness.query_by_label("spectrogram").is_some());
    analyse(&mut bench, at, &["observed", "Derivative"]);
    let (_, seen) = bench.harness.state().analyses().last().expect("it is there");
    assert!(matches!(seen, TraceAnalysis::Derivative(slope) if slope.values.len() > 50));
    analyse(&mut bench, at, &["observed", "Scatter against", "CY, fit ± 95 % band"]);
    let (request, seen) = bench.harness.state().analyses().last().expect("it is there");
    let TraceAnalysis::Scatter { correlation, line, .. } = seen else { panic!("a scatter") };
    assert!(request.over.is_some() && *correlation > 0.5 && line[0] > 0.2, "the fit follows: {correlation} {line:?}");
    pictures(&mut bench, "analyses", true);
}

#[test]
fn list_of_edits_goes_back_to_where_it_is_clicked_and_forward_again() {
    let mut bench = Bench::open();
    bench.show(Pane::Noise);
    let start = bench.session().clone();
    bench.enter("R alpha", "0.25");
    let first = bench.session().clone();
    bench.enter("R alpha", "0.5");
    bench.enter("Q q", "0.5");
    let last = bench.session().clone();
    bench.request(UiCommand::Edit(EditCommand::History));
    let (steps, done) = bench.harness.state().document.history.steps();
    let names: Vec<String> = steps.iter().enumerate().map(|(at, step)| format!("history {}: {step}", at + 1)).collect();
    assert_eq!((names.len(), done), (3, 3));
    picture(&mut bench.harness, "history");
    bench.click(&names[0]);
    assert_eq!(bench.session(), &first);
    picture(&mut bench.harness, "history_back");
    bench.click("history 0: Start");
    assert_eq!(bench.session(), &start);
    bench.click(&names[2]);
    assert_eq!(bench.session(), &last);
    bench.request(UiCommand::Edit(EditCommand::Undo));
    assert_eq!(bench.harness.state().document.history.steps().1, 2, "undo goes on from there");
}

#[test]
fn innovations_and_steady_flight_are_both_shown_where_they_differ_and_the_taken_one_brings_the_nis_nearer_one() {
    let mut bench = Bench::shipped();
    bench.show(Pane::Noise);
    let noise = |bench: &Bench<'_>| {
        let details = bench.snapshot().details.ready().expect("it was looked at").clone();
        details.window.as_ref().expect("a manoeuvre is chosen").noise.clone()
    };
    let all = noise(&bench);
    assert!(all.len() > 5, "{}", all.len());
    for advice in all.iter().filter(|advice| advice.step == NoiseStep::Differ) {
        assert!(!advice.reason.is_empty(), "{:?}", advice.measurement);
        for kind in ["innovations", "recorded"] {
            let label = format!("take {kind} R {}", advice.measurement.name());
            assert!(bench.harness.query_by_label(&label).is_some(), "{label}");
        }
    }
    pictures(&mut bench, "noise", false);
    let taken = all.iter().find(|advice| advice.recommended().is_some()).cloned();
    let taken = taken.expect("some noise is to be set");
    let ratio = |bench: &Bench<'_>, of: Measurement| {
        let window = bench.harness.state().state.selection.window.clone().expect("a manoeuvre is chosen");
        let path = bench.snapshot().windows[&window].path.ready().expect("it is up to date").clone();
        let channels = &path.assessment().consistency.as_ref().expect("it has measurements").channels;
        channels.iter().find(|channel| channel.measurement == of).expect("it was taken").deviation_ratio.powi(2)
    };
    let before = ratio(&bench, taken.measurement);
    assert!((taken.used.nis / before - 1.0).abs() < 1e-9, "the NIS shown is that of the innovations");
    bench.click(&format!("take innovations R {}", taken.measurement.name()));
    let after = ratio(&bench, taken.measurement);
    assert!((after - 1.0).abs() < (before - 1.0).abs(), "{:?}: NIS {before}, then {after}", taken.measurement);
    let set = bench.session().filter.measurement_noise[taken.measurement as usize];
    assert_eq!(Some(set), taken.innovations.map(|one| one.std));
    bench.show(Pane::Innovations);
    bench.click("Advice");
    pictures(&mut bench, "advice", false);
    for advice in noise(&bench) {
        let Some((one, other)) = advice.innovations.zip(advice.steady) else { continue };
        let factor = (one.std / other.std).max(other.std / one.std);
        assert_eq!(factor > 1.5, advice.step == NoiseStep::Differ, "{:?}: {factor}", advice.measurement);
    }
}
