//! Files that claim more than they hold: memory and time are bounded by what is really there.

use std::io::Write;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use doublet_core::load::{BUDGET_VARIABLE, inspect};

use super::{element, fixture, written};

/// A file of some kilobytes is refused or read in this time; one whose claims are believed takes far longer, or ends the program.
const PATIENCE: Duration = Duration::from_secs(2);

#[track_caller]
fn refused(name: &str, contents: &[u8], parts: &[&str]) {
    let (_folder, path) = written(name, contents);
    let begun = Instant::now();
    let line = inspect(&path).unwrap_err().to_string();
    assert!(begun.elapsed() < PATIENCE, "{line} after {:?}", begun.elapsed());
    for part in parts.iter().chain(&[name]) {
        assert!(line.contains(part) && !line.contains('\n'), "'{part}' is not in: {line}");
    }
}

/// A MAT file of one array of `class`, with dimensions as 64-bit integers, and what follows its name.
fn mat(class: u8, dims: &[i64], rest: &[u8]) -> Vec<u8> {
    let dims: Vec<u8> = dims.iter().flat_map(|dim| dim.to_le_bytes()).collect();
    let parts = [element(6, &[class, 0, 0, 0, 0, 0, 0, 0]), element(12, &dims), element(1, b"x"), rest.to_vec()];
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    file.extend(element(14, &parts.concat()));
    file
}

#[test]
fn hdf5_sets_that_claim_too_much_together_are_left_out() {
    let begun = Instant::now();
    let probe = inspect(&fixture("claims_together.h5")).unwrap();
    assert!(begun.elapsed() < PATIENCE);
    let beyond = |line: &String| line.contains("more than the file can hold");
    let messages: Vec<_> = probe.warnings.iter().map(ToString::to_string).filter(beyond).collect();
    assert!(messages.len() > 2 && messages.len() < 8, "the first alone could be: {:?}", probe.warnings);
    assert_eq!(probe.sources[0].channels.len() + messages.len(), 8);
}

#[test]
fn hdf5_sets_of_kinds_that_are_not_read_leave_the_others() {
    let probe = inspect(&fixture("odd.h5")).unwrap();
    let names: Vec<_> = probe.sources[0].channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["time", "q"]);
    assert_eq!(super::channel(&probe, "odd", "q").values(), super::made(50, |i, _| i));
    for name in ["'lzf'", "'nothing'", "'unwritten'", "'unwritten_chunks'"] {
        let count = probe
            .warnings
            .iter()
            .filter(|line| line.to_string().contains(name) && line.to_string().contains("left out"))
            .count();
        assert_eq!(count, 1, "{name}: {:?}", probe.warnings);
    }
}

#[test]
fn a_virtual_hdf5_set_leaves_the_others() {
    let probe = inspect(&fixture("virtual.h5")).unwrap();
    let names = |at: usize| probe.sources[at].channels.iter().map(|channel| channel.name.as_str()).collect::<Vec<_>>();
    assert_eq!(names(0), ["time", "q"]);
    assert_eq!(names(1), ["r", "time"], "a group beside it, with the clock above it");
    assert_eq!(super::channel(&probe, "virtual", "q").values(), super::made(50, |i, _| i));
    let messages: Vec<_> =
        probe.warnings.iter().filter(|line| line.to_string().contains("virtual: store its values")).collect();
    assert_eq!(messages.len(), 2, "{:?}", probe.warnings);
    assert!(messages.iter().any(|line| line.to_string().contains("'whole'")), "{messages:?}");
    assert!(messages.iter().any(|line| line.to_string().contains("'below/part'")), "{messages:?}");
}

/// Set for the process that reads with a budget of 20 MB: the file.
const CHILD: &str = "DOUBLET_TEST_RECORDING";

#[test]
#[ignore = "run by the test that sets its budget"]
fn child_that_reads_within_a_budget() {
    if let Some(path) = std::env::var_os(CHILD) {
        println!("SAID {}", inspect(Path::new(&path)).map_or_else(|error| error.to_string(), |_| "read".to_owned()));
    }
}

fn said_within(budget_mb: &str, path: &Path) -> String {
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", "load::claims::child_that_reads_within_a_budget", "--ignored", "--nocapture"]);
    let output = child.env(BUDGET_VARIABLE, budget_mb).env(CHILD, path).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.lines().find_map(|line| line.split_once("SAID ")).map(|(_, message)| message.to_owned()).unwrap_or(text)
}

#[test]
fn what_unpacks_to_more_than_the_budget_is_refused_as_too_large() {
    // 8 million characters are 8 MB, and 64 MB as numbers.
    let plain = mat(9, &[8_000_000, 1], &element(2, &vec![0; 8_000_000]));
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(&plain[128..]).unwrap();
    let packed = packed.finish().unwrap();
    let (_folder, path) = written(
        "zeros.mat",
        [&plain[..128], &15_u32.to_le_bytes(), &(packed.len() as u32).to_le_bytes(), &packed].concat(),
    );
    for (path, needs_mb) in [(path, 72), (fixture("expands.h5"), 96)] {
        for budget in [needs_mb / 16, needs_mb / 4, needs_mb - 5] {
            let message = said_within(&budget.to_string(), &path);
            let expected = [
                "too large when unpacked",
                &format!("{budget} MB"),
                BUDGET_VARIABLE,
                path.file_name().unwrap().to_str().unwrap(),
            ];
            assert!(
                expected.iter().all(|part| message.contains(part)) && !message.contains("damaged"),
                "{budget}: {message}"
            );
        }
        assert_eq!(said_within(&(needs_mb + 5).to_string(), &path), "read");
    }
}

#[test]
fn mat_arrays_that_claim_2_to_the_60_elements_are_refused() {
    const MANY: i64 = 1 << 60;
    refused("numbers.mat", &mat(6, &[MANY, 1], &element(9, &[0; 16])), &["dimensions give 1152921504606846976"]);
    refused("text.mat", &mat(4, &[1, MANY], &element(4, b"ab")), &["dimensions give"]);
    refused("cells.mat", &mat(1, &[MANY, 1], &[]), &["claims 1152921504606846976 elements"]);
    let names = [element(5, &8_i32.to_le_bytes()), element(1, b"a\0\0\0\0\0\0\0")].concat();
    refused("structs.mat", &mat(2, &[MANY, 1], &names), &["claims 1152921504606846976 elements"]);
    refused("product.mat", &mat(6, &[MANY, MANY], &[]), &["impossible dimensions"]);
}

#[test]
fn mat_text_of_many_rows_without_characters_is_empty_at_once() {
    let (_folder, path) = written("rows.mat", mat(4, &[1 << 60, 0], &element(4, &[])));
    let begun = Instant::now();
    let line = inspect(&path).unwrap_err().to_string();
    assert!(begun.elapsed() < PATIENCE);
    assert!(line.contains("rows.mat"), "it holds no numbers: {line}");
}

fn message(kind: u8, body: &[u8]) -> Vec<u8> {
    [&(body.len() as u16).to_le_bytes()[..], &[kind], body].concat()
}

fn ulog(messages: &[Vec<u8>]) -> Vec<u8> {
    [b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0".to_vec(), messages.concat()].concat()
}

#[test]
fn ulog_formats_that_claim_more_than_the_file_holds_are_refused() {
    let huge = message(b'F', b"f:float[1152921504606846976] x;");
    refused("array.ulg", &ulog(&[huge, message(b'A', b"\0\x01\0f")]), &["more than 65536 fields"]);
    let wide = message(b'F', b"f:uint8_t[65536] x;");
    let topics: Vec<_> = (0..4_u8).map(|id| message(b'A', &[0, id, 0, b'f'])).collect();
    refused("topics.ulg", &ulog(&[vec![wide], topics].concat()), &["more fields than the file has bytes"]);
    let long = format!("f:float[1000] {};", "x".repeat(60_000));
    refused("names.ulg", &ulog(&[message(b'F', long.as_bytes()), message(b'A', b"\0\x01\0f")]), &["longer than 255"]);
}

#[test]
fn ulog_messages_that_are_too_short_for_their_numbers_are_left_out() {
    let mut messages = vec![
        message(b'F', b"f:uint64_t timestamp;uint8_t[60000] x;uint8_t[4] _padding0;"),
        message(b'A', b"\0\x01\0f"),
    ];
    messages.extend((0..2000).map(|_| message(b'D', &[1, 0])));
    for stamp in [1_u64, 2] {
        let body = [&[1, 0][..], &(1000 * stamp).to_le_bytes(), &vec![stamp as u8; 60_000]].concat();
        messages.push(message(b'D', &body));
    }
    let (_folder, path) = written("short.ulg", ulog(&messages));
    let begun = Instant::now();
    let probe = inspect(&path).unwrap();
    assert!(begun.elapsed() < PATIENCE);
    assert!(
        probe.warnings.iter().any(|line| line.to_string().contains("2000 messages are too short")),
        "{:?}",
        probe.warnings
    );
    assert_eq!(probe.sources[0].channels[60_000].values(), [1.0, 2.0]);
}
