//! Every form of time histories is read back, by the reader of recordings where it reads the form.

use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::record::RowAccessor;
use doublet_core::load::{ChannelMap, read_all};
use doublet_core::quantity::Role;
use doublet_core::series::Recording;

use super::*;

const TIME_S: [f64; 4] = [10.0, 10.1, 10.2, 10.3];
const ALPHA_RAD: [f64; 4] = [0.1 + 0.2, -1e-17, f64::NAN, 1.0 / 3.0];
const AIRSPEED_M_S: [f64; 4] = [50.0, 51.5, 52.25, 1e300];

fn histories() -> Vec<History<'static>> {
    let columns = vec![
        HistoryColumn::new("aero/variables/alpha".into(), "rad", "angle of attack", &ALPHA_RAD),
        HistoryColumn::new("aero/airspeed".into(), "m/s", "true airspeed", &AIRSPEED_M_S),
    ];
    let history = |group: &str| History {
        group: group.to_owned(),
        kind: "aero".to_owned(),
        time_paths: vec!["aero/time".to_owned(), "aero/variables/time".to_owned()],
        time_s: Cow::Borrowed(&TIME_S),
        columns: columns.clone(),
    };
    vec![history("01 doublet"), history("01:doublet")]
}

fn written(format: HistoryFormat) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write(&histories(), "a title", format, folder.path(), &Control::default()).unwrap();
    folder
}

/// Equal, not a number included.
fn assert_same(found: &[f64], expected: &[f64]) {
    let bits =
        |values: &[f64]| -> Vec<u64> { values.iter().map(|v| if v.is_nan() { 0 } else { v.to_bits() }).collect() };
    assert_eq!(bits(found), bits(expected), "{found:?}");
}

fn assert_recording(recording: &Recording) {
    for (role, expected) in [(Role::AngleOfAttack, ALPHA_RAD), (Role::TrueAirspeed, AIRSPEED_M_S)] {
        let channel = recording.role(role).expect("the channel is read");
        assert_same(&channel.series.time_s, &TIME_S);
        assert_same(&channel.series.values, &expected);
    }
}

/// A map for the sources `outer` and `inner`.
fn map(outer: &str, inner: &str, separator: &str) -> ChannelMap {
    let text = format!(
        "format = \"doublet channel map\"\nversion = 1\nname = \"t\"\n\
         [[time]]\nchannel = \"{outer}{separator}time\"\nunit = \"s\"\n[[time]]\nchannel = \"{inner}{separator}time\"\nunit = \"s\"\n[roles]\n\
         alpha = {{ channel = \"{inner}{separator}alpha\", unit = \"rad\" }}\n\
         airspeed = {{ channel = \"{outer}{separator}airspeed\", unit = \"m/s\" }}\n"
    );
    ChannelMap::parse(&text).unwrap()
}

#[test]
fn mat_file_is_read_back_by_the_reader_of_recordings() {
    let folder = written(HistoryFormat::Mat);
    for group in ["w01_doublet", "w01_doublet_2"] {
        let map = map(&format!("{group}.aero"), &format!("{group}.aero.variables"), ".");
        assert_recording(&read_all(&[folder.path().join("histories.mat")], &map).unwrap());
    }
}

#[test]
fn hdf5_file_is_read_back_by_the_reader_of_recordings() {
    let folder = written(HistoryFormat::Hdf5);
    let map = map("01 doublet/aero", "01 doublet/aero/variables", "/");
    assert_recording(&read_all(&[folder.path().join("histories.h5")], &map).unwrap());
}

#[test]
fn csv_files_have_names_units_and_every_digit() {
    let folder = written(HistoryFormat::Csv);
    for file in ["01_doublet_aero.csv", "01_doublet_aero_2.csv"] {
        let mut reader = ::csv::Reader::from_path(folder.path().join("histories_csv").join(file)).unwrap();
        assert_eq!(reader.headers().unwrap(), vec!["time", "aero/variables/alpha", "aero/airspeed"]);
        let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows[0], vec!["s", "rad", "m/s"]);
        for (column, expected) in [TIME_S, ALPHA_RAD, AIRSPEED_M_S].iter().enumerate() {
            let number = |row: &::csv::StringRecord| row[column].parse().unwrap_or(f64::NAN);
            assert_same(&rows[1..].iter().map(number).collect::<Vec<_>>(), expected);
        }
        assert_eq!(&rows[3][1], "", "a value that does not exist is empty");
    }
}

#[test]
fn parquet_files_have_every_value_and_the_units() {
    let folder = written(HistoryFormat::Parquet);
    let file = std::fs::File::open(folder.path().join("histories_parquet/01_doublet_aero.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let metadata = reader.metadata().file_metadata();
    let unit = |column: &str| {
        let entries = metadata.key_value_metadata().unwrap();
        entries.iter().find(|entry| entry.key == format!("unit:{column}")).and_then(|entry| entry.value.clone())
    };
    assert_eq!(unit("aero_variables_alpha").as_deref(), Some("rad"));
    assert_eq!(unit("time").as_deref(), Some("s"));
    let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
    for (column, expected) in [TIME_S, ALPHA_RAD, AIRSPEED_M_S].iter().enumerate() {
        assert_same(&rows.iter().map(|row| row.get_double(column).unwrap()).collect::<Vec<_>>(), expected);
    }
}

#[test]
fn cancelled_writing_says_so() {
    let control = Control::default();
    control.cancel();
    let folder = tempfile::tempdir().unwrap();
    let result = write(&histories(), "", HistoryFormat::Csv, folder.path(), &control);
    assert!(matches!(result, Err(ReportError::Cancelled)));
}

#[test]
fn names_stay_apart_and_within_their_length() {
    let mut names = Names::default();
    assert_eq!(names.unique(file_name("../a b/c"), 6), "_a_b_c");
    assert_eq!(names.unique(file_name("_a_b_c"), 6), "_a_b_2");
    assert_eq!(names.unique(file_name("_a_b_c"), 6), "_a_b_3");
}
