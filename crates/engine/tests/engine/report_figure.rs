//! What the author adds to the report: figures, date and crew of a flight; what of them is saved, undone and read again.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a helper that fails is a failed test

use doublet_core::series::Series;
use doublet_engine::builtin;
use doublet_engine::report::document::{Axis, Colour, Figure, LineStyle, Mark, Matrix, Panel, Plot};
use doublet_engine::session::{self, Edit, EditError, ReportFigure, ReportFigureEdit};
use doublet_engine::undo::History;

/// A sine late in a flight at 100 Hz with one spike of a single sample, a gap, a band and a matrix.
fn figure() -> Figure {
    let time_s: Vec<f64> =
        (0..60_000).map(|k| 50_000.0 + 0.01 * f64::from(k) + if k < 30_000 { 0.0 } else { 40.0 }).collect();
    let values = (0..60_000).map(|k| if k == 12_345 { 9.0 } else { (0.001 * f64::from(k)).sin() });
    let series = Series { time_s: time_s.into(), values: values.collect() };
    let (label, colour) = ("q [deg/s]".into(), Colour::by_index(1));
    let half_width = vec![0.25; series.values.len()].into();
    let band = Mark::Band { label: "".into(), colour, centre: series.clone(), half_width, scale: 2.0 };
    let line = Mark::Line { label, colour, style: LineStyle::Solid, series, scale: 2.0 };
    let x = Axis { range: Some([50_000.0, 50_700.0]), ..Axis::time() };
    let plot = Plot { x, y: Axis::new("q", "deg/s"), marks: vec![band, line] };
    let values = vec![vec![f64::NAN, 0.5], vec![0.5, f64::NAN]];
    let names = vec!["a".to_owned(), "b".to_owned()];
    let matrix = Matrix { title: "m".to_owned(), names, values, full_scale: 1.0 };
    let panels = vec![Panel::Plot(plot), Panel::Matrix(matrix)];
    Figure::new("f", "rates", (1, 40.0), panels)
}

#[test]
fn saved_figure_keeps_extremes_gaps_and_words_in_a_part_of_its_size() {
    let kept = ReportFigure::from_figure(&figure()).unwrap();
    let saved = toml::to_string(&kept).unwrap();
    assert!(saved.len() < 40_000, "{} characters for 60,000 samples", saved.len());
    let mut renamed = kept;
    "as flown".clone_into(&mut renamed.caption);
    let back = renamed.figure().unwrap();
    assert_eq!((back.caption.as_str(), back.name.as_str(), back.columns), ("as flown", "f", 1));
    let [Panel::Plot(plot), Panel::Matrix(matrix)] = back.panels.as_slice() else { panic!("two panels") };
    assert_eq!(plot.x.range, Some([50_000.0, 50_700.0]));
    assert!(matrix.values[0][0].is_nan() && matrix.values[0][1] == 0.5);
    let [Mark::Band { centre, half_width, .. }, Mark::Points { label, points, .. }] = plot.marks.as_slice() else {
        panic!("a band and points: {:?}", plot.marks);
    };
    assert_eq!((label.as_ref(), half_width.len()), ("q [deg/s]", centre.values.len()));
    let spike = points.iter().find(|point| point[1] == 18.0).expect("the spike of one sample is drawn");
    assert!((spike[0] - 50_123.45).abs() < 1e-4, "where it was: {}", spike[0]);
    assert_eq!(points.iter().filter(|point| point[1].is_nan()).count(), 1, "one gap, no line across it");
    // Thinned once more it is what it is.
    let again = ReportFigure::from_figure(&ReportFigure::from_figure(&figure()).unwrap().figure().unwrap())
        .unwrap()
        .figure()
        .unwrap();
    let Panel::Plot(again) = &again.panels[0] else { panic!("a plot") };
    let Mark::Points { points: again, .. } = &again.marks[1] else { panic!("points") };
    assert!(again.iter().flatten().zip(points.iter().flatten()).all(|(a, b)| a.total_cmp(b).is_eq()));
}

#[test]
fn figures_of_the_report_are_saved_undone_and_a_damaged_one_is_named() {
    let session = session::parse(builtin::session("demo").unwrap()).unwrap();
    let before = session::print(&session).unwrap();
    assert!(!before.contains("report_figure"), "a session without figures reads as it always did");
    let mut history = History::new(session);
    let edit = |history: &mut History, edit| -> Result<(), EditError> { history.apply(&Edit::ReportFigure(edit)) };
    edit(&mut history, ReportFigureEdit::Add(ReportFigure::from_figure(&figure()).unwrap())).unwrap();
    edit(&mut history, ReportFigureEdit::Caption(0, "as flown".to_owned())).unwrap();
    assert_eq!(history.undo_label(), Some("change the caption of a report figure"));
    let text = session::print(history.present()).unwrap();
    assert_eq!(session::parse(&text).unwrap(), **history.present());
    let at = text.find("drawing = \"").expect("it is in the file") + 30;
    let damaged = format!("{}!!{}", &text[..at], &text[at + 2..]);
    let message = session::parse(&damaged).unwrap_err().to_string();
    assert!(message.contains("report_figure 'as flown'") && message.contains("choose the plot again"), "{message}");
    edit(&mut history, ReportFigureEdit::Remove(0)).unwrap();
    assert_eq!(session::print(history.present()).unwrap(), before);
    assert!(edit(&mut history, ReportFigureEdit::Remove(0)).is_err());
    assert!(edit(&mut history, ReportFigureEdit::Caption(0, "none".to_owned())).is_err());
    for _ in 0..3 {
        history.undo();
    }
    assert!(history.present().report_figures.is_empty());
}

#[test]
fn date_and_crew_of_a_flight_are_edited_without_reading_it_anew() {
    let session = session::parse(builtin::session("demo").unwrap()).unwrap();
    let name = session.flights[0].name.clone();
    let mut history = History::new(session);
    let log = |flight: &str, crew: &str| Edit::FlightLog {
        flight: flight.to_owned(),
        date: "2026-05-05".to_owned(),
        crew: crew.to_owned(),
    };
    let before = history.present().flights[0].as_read();
    history.apply(&log(&name, "C. Pilot")).unwrap();
    let flight = &history.present().flights[0];
    assert_eq!((flight.date.as_str(), flight.crew.as_str()), ("2026-05-05", "C. Pilot"));
    assert_eq!(flight.as_read(), before);
    assert!(matches!(history.apply(&log("none", "")), Err(EditError::NoFlight(_))));
    assert!(matches!(history.apply(&log(&name, "a\u{1}b")), Err(EditError::Name(_))));
    assert!(history.undo());
    assert_eq!(history.present().flights[0].crew, "");
}
