//! `run`, `report` and `export` into a folder where the user keeps files too, as a user runs them.

use std::path::Path;
use std::process::Command;

/// The shipped session with one window of every surface.
fn small_session(folder: &Path) -> String {
    let mut session: toml::Table = toml::from_str(include_str!("../../../../sessions/demo.toml")).unwrap();
    let windows = session["manoeuvre"].as_array_mut().unwrap();
    let mut kept = Vec::new();
    for surface in ["elevator", "aileron", "rudder"] {
        kept.extend(windows.iter().find(|window| window["surface"].as_str() == Some(surface)).cloned());
    }
    *windows = kept;
    let path = folder.join("small.toml");
    std::fs::write(&path, toml::to_string(&session).unwrap()).unwrap();
    path.to_str().unwrap().to_owned()
}

fn doublet(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_doublet-cli")).args(arguments).output().unwrap();
    let printed = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    (output.status.code(), printed)
}

#[cfg(unix)]
#[test]
fn files_of_the_user_stay_in_a_folder_of_results() {
    use std::os::unix::fs::PermissionsExt;
    let root = tempfile::tempdir().unwrap();
    let session = small_session(root.path());
    let (real, link) = (root.path().join("real"), root.path().join("link"));
    std::os::unix::fs::symlink(&real, &link).unwrap();
    let out = link.to_str().unwrap();
    let (code, printed) = doublet(&["run", &session, "--out", out]);
    assert!(code.is_some_and(|code| code != 1), "{printed}");
    std::fs::write(real.join("mine.txt"), "mine").unwrap();
    std::fs::create_dir(real.join("plots")).unwrap();
    std::fs::write(real.join("plots/a.png"), "p").unwrap();
    std::fs::write(real.join("windows.csv"), "with remarks").unwrap();
    // A table that this run does not write is gone with the run it belonged to.
    let (_, printed) = doublet(&["run", &session, "--out", out, "--tables", "csv", "--histories", "csv"]);
    assert!(printed.contains("windows.csv was changed after doublet wrote it"), "{printed}");
    let forms: [&[&str]; 2] = [
        &["report", &session, "--out", out, "--format", "html", "--sections", "overview"],
        &["export", &session, "--out", out],
    ];
    for arguments in forms {
        let (code, printed) = doublet(arguments);
        assert!(code.is_some_and(|code| code != 1), "{printed}");
    }
    let read = |name: &str| std::fs::read_to_string(real.join(name)).unwrap();
    assert_eq!(
        (read("mine.txt"), read("plots/a.png"), read("windows.csv.bak")),
        ("mine".into(), "p".into(), "with remarks".into())
    );
    assert!(link.is_symlink() && real.join("small.html").exists() && !real.join("histories.h5").exists());
    let mode = |name: &str| real.join(name).metadata().unwrap().permissions().mode() & 0o777;
    let usual = mode("mine.txt");
    let files: Vec<_> =
        std::fs::read_dir(&real).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file()).collect();
    for file in files {
        assert_eq!(mode(file.file_name().unwrap().to_str().unwrap()), usual, "{}", file.display());
    }
    let left = std::fs::read_dir(root.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert_eq!(left.filter(|name| name.starts_with('.')).count(), 0);
    // A file of the user that has the name of a table is not replaced.
    std::fs::write(real.join("derivatives.tex"), "mine").unwrap();
    let (code, printed) = doublet(&["run", &session, "--out", out, "--tables", "latex"]);
    assert!(
        code == Some(1) && printed.contains("derivatives.tex exists and was not written by doublet"),
        "{code:?} {printed}"
    );
    assert!(read("derivatives.tex") == "mine" && real.join("derivatives.csv").exists());
}
