//! Functions of FMI 3.0 (Modelica Association, "Functional Mock-up Interface Specification", version 3.0.1).
//!
//! # Safety
//! All of them trust their caller as the specification lets them: pointers are those that a function before gave, arrays as long as is
//! said beside them.

use std::ffi::{CStr, c_char, c_void};
use std::path::Path;

use crate::instance::{Instance, TOKEN_PREFIX};

/// What a function says of how it went.
type Status = i32;
const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;

/// A line for the log of the simulator.
type Log = Option<unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char)>;

/// The instance behind a pointer.
unsafe fn instance<'a>(pointer: *mut c_void) -> Option<&'a mut Instance> {
    // SAFETY: a pointer of the simulator is one that an instantiation gave and nothing has freed.
    unsafe { pointer.cast::<Instance>().as_mut() }
}

/// Text behind a pointer; empty where there is none.
unsafe fn text<'a>(pointer: *const c_char) -> &'a str {
    if pointer.is_null() {
        return "";
    }
    // SAFETY: strings of the interface end with NUL.
    unsafe { CStr::from_ptr(pointer) }.to_str().unwrap_or_default()
}

/// Reads the model beside the library, checks that it is the one the description is of, and gives a pointer to the instance.
unsafe fn instantiate(
    token: *const c_char,
    resources: *const c_char,
    environment: *mut c_void,
    log: Log,
) -> *mut c_void {
    // SAFETY: strings as the specification has them.
    let (token, resources) = unsafe { (text(token), text(resources)) };
    let resources = resources.strip_prefix("file://").unwrap_or(resources);
    let path = Path::new(resources).join("model.json");
    match read_instance(token, &path) {
        Ok(instance) => Box::into_raw(Box::new(instance)).cast(),
        Err(line) => {
            if let (Some(log), Ok(line)) = (log, std::ffi::CString::new(line)) {
                // SAFETY: the callback and its environment are the simulator's own.
                unsafe { log(environment, ERROR, c"logStatusError".as_ptr(), line.as_ptr()) };
            }
            std::ptr::null_mut()
        }
    }
}

fn read_instance(token: &str, path: &Path) -> Result<Instance, String> {
    if !token.starts_with(TOKEN_PREFIX) {
        return Err(format!("the instantiation token '{token}' is not one of a flight model of this library"));
    }
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    Instance::new(&text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Version of the interface.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    log: Log,
) -> *mut c_void {
    // SAFETY: as this function.
    unsafe { instantiate(token, resources, environment, log) }
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _intermediates: usize,
    environment: *mut c_void,
    log: Log,
    _update: *const c_void,
) -> *mut c_void {
    // SAFETY: as this function.
    unsafe { instantiate(token, resources, environment, log) }
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(pointer: *mut c_void) {
    if !pointer.is_null() {
        // SAFETY: it came from `Box::into_raw` and is not used after this.
        drop(unsafe { Box::from_raw(pointer.cast::<Instance>()) });
    }
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    pointer: *mut c_void,
    _has_tolerance: bool,
    _tolerance: f64,
    start_s: f64,
    _has_stop: bool,
    _stop_s: f64,
) -> Status {
    // SAFETY: as this function.
    let Some(instance) = (unsafe { instance(pointer) }) else { return ERROR };
    instance.set_time(start_s);
    OK
}

macro_rules! modes {
    ($($name:ident)*) => {
        $(
            /// Nothing has to be done for it.
            #[unsafe(no_mangle)]
            pub extern "C" fn $name(_pointer: *mut c_void) -> Status {
                OK
            }
        )*
    };
}

modes!(fmi3ExitInitializationMode fmi3EnterEventMode fmi3Terminate fmi3EnterContinuousTimeMode fmi3EnterConfigurationMode
    fmi3ExitConfigurationMode fmi3EnterStepMode fmi3EvaluateDiscreteStates);

/// Every message is logged, whatever is asked for.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3SetDebugLogging(
    _pointer: *mut c_void,
    _on: bool,
    _categories: usize,
    _names: *const *const c_char,
) -> Status {
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(pointer: *mut c_void) -> Status {
    // SAFETY: as this function.
    let Some(instance) = (unsafe { instance(pointer) }) else { return ERROR };
    instance.reset();
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    pointer: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
    _length: usize,
) -> Status {
    // SAFETY: as this function.
    let Some(instance) = (unsafe { instance(pointer) }) else { return ERROR };
    if count == 0 {
        return OK;
    }
    // SAFETY: both arrays have `count` elements, every variable being a scalar.
    let (references, values) =
        unsafe { (std::slice::from_raw_parts(references, count), std::slice::from_raw_parts_mut(values, count)) };
    if instance.get(references, values).is_none() {
        return ERROR;
    }
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    pointer: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
    _length: usize,
) -> Status {
    // SAFETY: as this function.
    let Some(instance) = (unsafe { instance(pointer) }) else { return ERROR };
    for index in 0..count {
        // SAFETY: both arrays have `count` elements, every variable being a scalar.
        let (reference, value) = unsafe { (*references.add(index), *values.add(index)) };
        if instance.set(reference, value).is_none() {
            return ERROR;
        }
    }
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    _pointer: *mut c_void,
    again: *mut bool,
    ends: *mut bool,
    nominals: *mut bool,
    values: *mut bool,
    has_event: *mut bool,
    event_s: *mut f64,
) -> Status {
    for flag in [again, ends, nominals, values, has_event] {
        // SAFETY: the simulator gives a place for each.
        unsafe { *flag = false };
    }
    // SAFETY: as above.
    unsafe { *event_s = 0.0 };
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    _pointer: *mut c_void,
    _no_return: bool,
    event: *mut bool,
    ends: *mut bool,
) -> Status {
    // SAFETY: the simulator gives a place for each.
    unsafe { (*event, *ends) = (false, false) };
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(pointer: *mut c_void, time_s: f64) -> Status {
    // SAFETY: as this function.
    let Some(instance) = (unsafe { instance(pointer) }) else { return ERROR };
    instance.set_time(time_s);
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetContinuousStates(pointer: *mut c_void, states: *const f64, count: usize) -> Status {
    // SAFETY: as this function.
    let Some(instance) = (unsafe { instance(pointer) }) else { return ERROR };
    let state = instance.state_mut();
    if count != state.len() {
        return ERROR;
    }
    // SAFETY: the array has `count` elements.
    state.copy_from_slice(unsafe { std::slice::from_raw_parts(states, count) });
    OK
}

/// Writes as many values as there are states.
unsafe fn write(values: *mut f64, count: usize, found: Option<&[f64]>) -> Status {
    let Some(found) = found.filter(|found| found.len() == count) else { return ERROR };
    // SAFETY: the array has `count` elements.
    unsafe { std::slice::from_raw_parts_mut(values, count) }.copy_from_slice(found);
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStates(pointer: *mut c_void, states: *mut f64, count: usize) -> Status {
    // SAFETY: as this function.
    unsafe { write(states, count, instance(pointer).map(|instance| &instance.state()[..])) }
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetContinuousStateDerivatives(
    pointer: *mut c_void,
    rates: *mut f64,
    count: usize,
) -> Status {
    // SAFETY: as this function.
    let found = unsafe { instance(pointer) }.and_then(|instance| instance.rates());
    // SAFETY: as this function.
    unsafe { write(rates, count, found.as_ref().map(|found| &found[..])) }
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNominalsOfContinuousStates(
    pointer: *mut c_void,
    nominals: *mut f64,
    count: usize,
) -> Status {
    /// Of velocities, rates, angles and places.
    const NOMINALS: [f64; 12] = [10.0, 1.0, 1.0, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 100.0, 100.0, 100.0];
    if pointer.is_null() {
        return ERROR;
    }
    // SAFETY: as this function.
    unsafe { write(nominals, count, Some(&NOMINALS)) }
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfContinuousStates(pointer: *mut c_void, count: *mut usize) -> Status {
    // SAFETY: as this function.
    let Some(instance) = (unsafe { instance(pointer) }) else { return ERROR };
    // SAFETY: the simulator gives a place for it.
    unsafe { *count = instance.state().len() };
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfEventIndicators(_pointer: *mut c_void, count: *mut usize) -> Status {
    // SAFETY: the simulator gives a place for it.
    unsafe { *count = 0 };
    OK
}

/// There are none.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetEventIndicators(_pointer: *mut c_void, _indicators: *mut f64, count: usize) -> Status {
    if count == 0 { OK } else { ERROR }
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    pointer: *mut c_void,
    time_s: f64,
    duration_s: f64,
    _no_return: bool,
    event: *mut bool,
    ends: *mut bool,
    early: *mut bool,
    reached_s: *mut f64,
) -> Status {
    // SAFETY: as this function.
    let Some(instance) = (unsafe { instance(pointer) }) else { return ERROR };
    let is_flown = duration_s >= 0.0 && instance.step(time_s, duration_s).is_some();
    // SAFETY: the simulator gives a place for each.
    unsafe {
        (*event, *ends, *early) = (false, false, false);
        *reached_s = if is_flown { time_s + duration_s } else { time_s };
    }
    if is_flown { OK } else { DISCARD }
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(pointer: *mut c_void, kept: *mut *mut c_void) -> Status {
    // SAFETY: as this function.
    let Some(instance) = (unsafe { instance(pointer) }) else { return ERROR };
    // SAFETY: the simulator gives a place for it, and what stood there is null or was given here.
    unsafe {
        fmi3FreeFMUState(pointer, kept);
        *kept = Box::into_raw(Box::new(instance.clone())).cast();
    }
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(pointer: *mut c_void, kept: *mut c_void) -> Status {
    // SAFETY: as this function; what is kept is an instance too.
    let (Some(own), Some(other)) = (unsafe { instance(pointer) }, unsafe { instance(kept) }) else { return ERROR };
    other.clone_into(own);
    OK
}

/// # Safety
/// See the module.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(_pointer: *mut c_void, kept: *mut *mut c_void) -> Status {
    // SAFETY: it points to null or to what `fmi3GetFMUState` gave.
    unsafe {
        fmi3FreeInstance(*kept);
        *kept = std::ptr::null_mut();
    }
    OK
}
