//! The public recording of a real flight: chosen on the start page, recognised by its contents, opened as its worked case.

use std::path::Path;

use doublet::command::{FileCommand, UiCommand, ViewCommand};
use doublet_core::model::Coefficient;
use egui::Key;
use egui_kittest::kittest::Queryable;

use crate::picture;
use crate::workbench::Bench;

/// Where the recording is beside the repository, if it is there.
const RECORDING: &str = "../shared/data/attas";
/// `Cm_alpha` and `Cm_delta_e` as published, and how near ours must come, relative.
const PUBLISHED: [(&str, f64); 2] = [("Cm_alpha", -0.877_620), ("Cm_delta_e", -0.984_060)];
const NEAR: f64 = 0.05;

/// Types a file into the dialog and confirms.
fn choose_file(bench: &mut Bench<'_>, name: &str) {
    bench.harness.get_by_label("File name").type_text(name);
    bench.harness.run_steps(2);
    bench.harness.key_press(Key::Enter);
    bench.settle();
}

#[test]
fn files_of_the_public_recording_are_recognised_by_their_contents() {
    let mut bench = Bench::open();
    bench.request(UiCommand::View(ViewCommand::StartPage));
    picture(&mut bench.harness, "start_public");
    bench.click("Choose its files…");
    let other = bench.folder.path().join("flight.csv");
    choose_file(&mut bench, &other.display().to_string());
    let message = bench.harness.state().message.clone().expect("something is said");
    assert!(
        message.is_error && message.text.contains("fAttasElv1.mat") && message.text.contains("2e406739"),
        "{message:?}"
    );
    assert_eq!(bench.session().title, "Test flight", "the session stays");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(RECORDING);
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return;
    }
    bench.request(UiCommand::File(FileCommand::OpenPublic));
    // Whatever they are called.
    let own = bench.folder.path().join("own");
    std::fs::create_dir(&own).expect("there is room");
    for (name, copy) in [("fAttasElv1", "a"), ("fAttasAil1", "b"), ("fAttasRud1", "c")] {
        std::fs::copy(folder.join(format!("{name}.mat")), own.join(format!("{copy}.mat"))).expect("it can be copied");
    }
    choose_file(&mut bench, &own.display().to_string());
    crate::click(&mut bench.harness, "a.mat", 2);
    for name in ["b.mat", "c.mat"] {
        bench.harness.get_by_label(name).click_modifiers(egui::Modifiers::COMMAND);
        bench.harness.run_steps(2);
    }
    bench.choose("Open");
    assert_eq!(bench.snapshot().failures(), []);
    assert_eq!(bench.session().windows.len(), 3);
    let pooled = bench.snapshot().pooled.ready().expect("it is estimated").clone();
    let fit = pooled.fits.iter().find(|fit| fit.coefficient == Coefficient::Cm).expect("Cm is modelled");
    for (name, published) in PUBLISHED {
        let (estimate, _) = fit.fit.as_ref().expect("it is estimated").parameter(name).expect("it is a term");
        assert!((estimate / published - 1.0).abs() < NEAR, "{name}: {estimate}, published {published}");
    }
    picture(&mut bench.harness, "public_opened");
}
