//! The identified aircraft as a Functional Mock-up Unit (FMI 3.0): description, model and library in one archive.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use doublet_dynamics::linear::Simulation;
use doublet_fmu::{TOKEN_PREFIX, Unit, Variable, VariableKind, variables};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::ExportError;
use quick_xml::escape::escape;

/// Libraries besides those in the program's own folder, separated as in the search path of the system.
pub const LIBRARY_VARIABLE: &str = "DOUBLET_FMU_LIBRARY";
/// Name of the library without what systems put before and behind it.
const LIBRARY: &str = "doublet_fmu";
/// File names of the library on every system.
const LIBRARY_FILES: [&str; 3] = ["libdoublet_fmu.so", "doublet_fmu.dll", "libdoublet_fmu.dylib"];

/// Writes `simulation`, whose derivatives have `names`, to the archive `path`.
pub fn write_fmu(simulation: &Simulation, names: &[String], aircraft: &str, path: &Path) -> Result<(), ExportError> {
    let file = |path: &Path| {
        let path = path.display().to_string();
        move |source: std::io::Error| ExportError::File { path, source }
    };
    let model = simulation.to_json().map_err(ExportError::NoModel)?;
    let mut entries = vec![
        ("modelDescription.xml".to_owned(), description(simulation, names, aircraft).into_bytes()),
        ("resources/model.json".to_owned(), model.into_bytes()),
    ];
    for library in libraries()? {
        let contents = std::fs::read(&library).map_err(file(&library))?;
        let (platform, suffix) = platform(&contents)
            .ok_or_else(|| ExportError::NoModel(format!("{} is not a library of a known system", library.display())))?;
        let name = format!("binaries/{platform}/{LIBRARY}{suffix}");
        if entries.iter().all(|(other, _)| *other != name) {
            entries.push((name, contents));
        }
    }
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, contents) in entries {
        let written = archive.start_file(name, SimpleFileOptions::default()).map_err(std::io::Error::from);
        written.and_then(|()| archive.write_all(&contents)).map_err(file(path))?;
    }
    let bytes = archive.finish().map_err(std::io::Error::from).map_err(file(path))?.into_inner();
    crate::keep::replace(path, &bytes).map_err(file(path))
}

/// The libraries: those that the environment names, or those of every system beside the program.
fn libraries() -> Result<Vec<PathBuf>, ExportError> {
    if let Some(paths) = std::env::var_os(LIBRARY_VARIABLE) {
        return Ok(std::env::split_paths(&paths).collect());
    }
    let program = std::env::current_exe().unwrap_or_default();
    let folder = program.parent().unwrap_or(Path::new("."));
    let folders = [folder.to_owned(), folder.join("../lib/doublet"), folder.join("deps")];
    let files = LIBRARY_FILES
        .iter()
        .filter_map(|name| folders.iter().map(|folder| folder.join(name)).find(|path| path.is_file()));
    let found: Vec<_> = files.collect();
    if found.is_empty() {
        let name = format!("{}{LIBRARY}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        return Err(ExportError::NoModel(format!(
            "{name} is not beside the program: build the package doublet-fmu, or name the library in {LIBRARY_VARIABLE}"
        )));
    }
    Ok(found)
}

/// Folder of the archive for a library and the suffix of its name, by the header of its file: ELF, PE or Mach-O.
fn platform(library: &[u8]) -> Option<(&'static str, &'static str)> {
    let bytes = |at: usize, count: usize| library.get(at..at.checked_add(count)?);
    let word = |at: usize| Some(u16::from_le_bytes(bytes(at, 2)?.try_into().ok()?));
    let long = |at: usize| Some(u32::from_le_bytes(bytes(at, 4)?.try_into().ok()?));
    match bytes(0, 4)? {
        b"\x7fELF" => match word(18)? {
            0x3e => Some(("x86_64-linux", ".so")),
            0xb7 => Some(("aarch64-linux", ".so")),
            _ => None,
        },
        [b'M', b'Z', ..] => {
            let header = long(0x3c)? as usize;
            match (bytes(header, 4)?, word(header + 4)?) {
                (b"PE\0\0", 0x8664) => Some(("x86_64-windows", ".dll")),
                (b"PE\0\0", 0xaa64) => Some(("aarch64-windows", ".dll")),
                _ => None,
            }
        }
        [0xcf, 0xfa, 0xed, 0xfe] => match long(4)? {
            0x0100_0007 => Some(("x86_64-darwin", ".dylib")),
            0x0100_000c => Some(("aarch64-darwin", ".dylib")),
            _ => None,
        },
        _ => None,
    }
}

/// `modelDescription.xml`.
fn description(simulation: &Simulation, names: &[String], aircraft: &str) -> String {
    let (aircraft, version) = (escape(aircraft), env!("CARGO_PKG_VERSION"));
    let token = format!("{TOKEN_PREFIX}{aircraft}");
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{aircraft}\" \
         instantiationToken=\"{token}\" generationTool=\"doublet {version}\" variableNamingConvention=\"structured\">\n  \
         <ModelExchange modelIdentifier=\"{LIBRARY}\" canGetAndSetFMUState=\"true\"/>\n  <CoSimulation modelIdentifier=\"{LIBRARY}\" \
         canGetAndSetFMUState=\"true\" canHandleVariableCommunicationStepSize=\"true\"/>\n  <UnitDefinitions>\n"
    );
    let variables = variables(simulation, names);
    let units: BTreeSet<Unit> = variables.iter().filter_map(|variable| variable.unit).chain([Unit::SECOND]).collect();
    for unit in units {
        let powers = [("kg", unit.kg), ("m", unit.m), ("s", unit.s), ("rad", unit.rad)];
        let powers = powers.iter().filter(|(_, power)| *power != 0).map(|(name, power)| format!(" {name}=\"{power}\""));
        _ = writeln!(text, "    <Unit name=\"{}\"><BaseUnit{}/></Unit>", unit.name(), powers.collect::<String>());
    }
    text += "  </UnitDefinitions>\n  <DefaultExperiment startTime=\"0\" stopTime=\"10\" stepSize=\"0.02\"/>\n  <ModelVariables>\n    \
             <Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\" unit=\"s\" \
             description=\"Time\"/>\n";
    for variable in &variables {
        _ = writeln!(text, "    {}", element(variable));
    }
    let is_rate = |kind: VariableKind| matches!(kind, VariableKind::Rate(_));
    let is_output = |kind: VariableKind| kind == VariableKind::Output;
    let elements: [(&str, &dyn Fn(VariableKind) -> bool); 4] = [
        ("Output", &|kind| kind == VariableKind::State || is_output(kind)),
        ("ContinuousStateDerivative", &is_rate),
        ("InitialUnknown", &is_rate),
        ("InitialUnknown", &is_output),
    ];
    let mut structure = String::new();
    for (element, has) in elements {
        for variable in variables.iter().filter(|variable| has(variable.kind)) {
            _ = writeln!(structure, "    <{element} valueReference=\"{}\"/>", variable.reference);
        }
    }
    text + "  </ModelVariables>\n  <ModelStructure>\n" + &structure + "  </ModelStructure>\n</fmiModelDescription>\n"
}

fn element(variable: &Variable) -> String {
    let Variable { reference, name, unit, description, kind, start } = variable;
    let (name, description) = (escape(name), escape(description));
    let unit = unit.map_or_else(String::new, |unit| format!(" unit=\"{}\"", unit.name()));
    let start = format!("start=\"{start:?}\"");
    let about = match kind {
        VariableKind::Input => format!("causality=\"input\" variability=\"continuous\" {start}"),
        VariableKind::State => format!("causality=\"output\" variability=\"continuous\" initial=\"exact\" {start}"),
        VariableKind::Rate(of) => {
            format!("causality=\"local\" variability=\"continuous\" initial=\"calculated\" derivative=\"{of}\"")
        }
        VariableKind::Output => "causality=\"output\" variability=\"continuous\" initial=\"calculated\"".to_owned(),
        VariableKind::Parameter => format!("causality=\"parameter\" variability=\"fixed\" initial=\"exact\" {start}"),
    };
    format!("<Float64 name=\"{name}\" valueReference=\"{reference}\"{unit} {about} description=\"{description}\"/>")
}

#[cfg(test)]
mod tests {
    use super::platform;

    #[test]
    fn library_goes_into_the_folder_of_its_system() {
        let mut elf = [0_u8; 64];
        elf[..4].copy_from_slice(b"\x7fELF");
        elf[18] = 0x3e;
        assert_eq!(platform(&elf), Some(("x86_64-linux", ".so")));
        elf[18] = 0x28;
        assert_eq!(platform(&elf), None);
        let mut dll = [0_u8; 160];
        dll[..2].copy_from_slice(b"MZ");
        dll[0x3c] = 0x80;
        dll[0x80..0x86].copy_from_slice(&[b'P', b'E', 0, 0, 0x64, 0x86]);
        assert_eq!(platform(&dll), Some(("x86_64-windows", ".dll")));
        dll[0x3f] = 0xff;
        assert_eq!(platform(&dll), None);
        assert_eq!(platform(&[0xcf, 0xfa, 0xed, 0xfe, 0x0c, 0, 0, 1]), Some(("aarch64-darwin", ".dylib")));
        assert_eq!(platform(b"MZ"), None);
    }
}
