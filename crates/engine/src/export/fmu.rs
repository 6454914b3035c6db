//! The identified aircraft as a Functional Mock-up Unit (FMI 3.0): description, model and library in one archive.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use doublet_dynamics::linear::Simulation;
use doublet_fmu::{TOKEN_PREFIX, VariableKind, variables};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::ExportError;
use quick_xml::escape::escape;

/// Where the library is looked for besides the program's own folder.
pub const LIBRARY_VARIABLE: &str = "DOUBLET_FMU_LIBRARY";
/// Name of the library without what systems put before and behind it.
const LIBRARY: &str = "doublet_fmu";
/// Units of the variables: name, exponents of m, kg, s, rad.
const UNITS: [(&str, &str); 6] = [
    ("m", "m=\"1\""),
    ("m/s", "m=\"1\" s=\"-1\""),
    ("m/s2", "m=\"1\" s=\"-2\""),
    ("rad", "rad=\"1\""),
    ("rad/s", "rad=\"1\" s=\"-1\""),
    ("N", "kg=\"1\" m=\"1\" s=\"-2\""),
];

/// Folder of the archive that the library of this system belongs in.
const PLATFORM: &str = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    "x86_64-linux"
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    "aarch64-linux"
} else if cfg!(all(target_os = "windows", target_arch = "x86_64")) {
    "x86_64-windows"
} else if cfg!(all(target_os = "macos", target_arch = "aarch64")) {
    "aarch64-darwin"
} else {
    "x86_64-darwin"
};

/// Writes `simulation`, whose derivatives have `names`, to the archive `path`.
///
/// # Errors
/// [`ExportError`]: the library is not there, or a file cannot be written.
pub fn write_fmu(simulation: &Simulation, names: &[String], aircraft: &str, path: &Path) -> Result<(), ExportError> {
    let file = |path: &Path| {
        let path = path.display().to_string();
        move |source: std::io::Error| ExportError::File { path, source }
    };
    let library = library()?;
    let contents = std::fs::read(&library).map_err(file(&library))?;
    let model = simulation.to_json().map_err(ExportError::NoModel)?;
    let library_name = format!("binaries/{PLATFORM}/{LIBRARY}{}", std::env::consts::DLL_SUFFIX);
    let description = description(simulation, names, aircraft);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let entries = [
        ("modelDescription.xml", description.as_bytes()),
        ("resources/model.json", model.as_bytes()),
        (&library_name, &contents),
    ];
    for (name, contents) in entries {
        let written = archive.start_file(name, SimpleFileOptions::default()).map_err(std::io::Error::from);
        written.and_then(|()| archive.write_all(contents)).map_err(file(path))?;
    }
    let bytes = archive.finish().map_err(std::io::Error::from).map_err(file(path))?.into_inner();
    crate::keep::replace(path, &bytes).map_err(file(path))
}

/// The library of this system: what the environment names, or what lies beside the program.
fn library() -> Result<PathBuf, ExportError> {
    if let Some(path) = std::env::var_os(LIBRARY_VARIABLE) {
        return Ok(path.into());
    }
    let name = format!("{}{LIBRARY}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let program = std::env::current_exe().unwrap_or_default();
    let folder = program.parent().unwrap_or(Path::new("."));
    let places = [folder.join(&name), folder.join("../lib/doublet").join(&name), folder.join("deps").join(&name)];
    places.into_iter().find(|path| path.is_file()).ok_or_else(|| {
        ExportError::NoModel(format!(
            "{name} is not beside the program: build the package doublet-fmu, or name the library in {LIBRARY_VARIABLE}"
        ))
    })
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
    for (unit, base) in UNITS {
        _ = writeln!(text, "    <Unit name=\"{unit}\"><BaseUnit {base}/></Unit>");
    }
    text += "  </UnitDefinitions>\n  <DefaultExperiment startTime=\"0\" stopTime=\"10\" stepSize=\"0.02\"/>\n  <ModelVariables>\n    \
             <Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\"/>\n";
    let variables = variables(simulation, names);
    for (reference, name, unit, kind, start) in &variables {
        let name = escape(name);
        let unit = if unit.is_empty() { String::new() } else { format!(" unit=\"{unit}\"") };
        let start = format!("start=\"{start:?}\"");
        let about = match kind {
            VariableKind::Input => format!("causality=\"input\" variability=\"continuous\" {start}"),
            VariableKind::State => format!("causality=\"output\" variability=\"continuous\" initial=\"exact\" {start}"),
            VariableKind::Rate(of) => {
                format!("causality=\"local\" variability=\"continuous\" initial=\"calculated\" derivative=\"{of}\"")
            }
            VariableKind::Output => "causality=\"output\" variability=\"continuous\" initial=\"calculated\"".to_owned(),
            VariableKind::Derivative => {
                format!("causality=\"parameter\" variability=\"fixed\" initial=\"exact\" {start}")
            }
        };
        _ = writeln!(text, "    <Float64 name=\"{name}\" valueReference=\"{reference}\"{unit} {about}/>");
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
        for (reference, ..) in variables.iter().filter(|(.., kind, _)| has(*kind)) {
            _ = writeln!(structure, "    <{element} valueReference=\"{reference}\"/>");
        }
    }
    text + "  </ModelVariables>\n  <ModelStructure>\n" + &structure + "  </ModelStructure>\n</fmiModelDescription>\n"
}
