//! The commit this program is built from.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=DOUBLET_COMMIT");
    println!("cargo::rerun-if-changed=build.rs");
    let is_release = env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = env::var("DOUBLET_COMMIT").ok().or_else(|| commit(is_release));
    let commit = commit.unwrap_or_else(|| "unknown".to_owned());
    let build = if is_release { format!("commit {commit}") } else { format!("debug build, commit {commit} or later") };
    println!("cargo::rustc-env=DOUBLET_COMMIT={commit}");
    println!("cargo::rustc-env=DOUBLET_BUILD={build}");
}

/// The commit of the source, where it is a checkout. Only a release follows every new commit: others would be built again for it.
fn commit(is_release: bool) -> Option<String> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
    };
    if is_release {
        for file in ["HEAD", "logs/HEAD"] {
            let place = git(&["rev-parse", "--path-format=absolute", "--git-path", file])?;
            println!("cargo::rerun-if-changed={place}");
        }
    }
    git(&["rev-parse", "--short=10", "HEAD"])
}
