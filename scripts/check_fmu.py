"""Flies a Functional Mock-up Unit of doublet in FMPy: co-simulation against model exchange, both against a Runge-Kutta integration of the
rates the unit itself gives, and against a second run after a reset."""

import shutil
import sys
from ctypes import c_double

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.validation import validate_fmu

path = sys.argv[1]
problems = validate_fmu(path)
assert not problems, problems

STATES = ["u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "north", "east", "h"]
STEP, STOP = 0.02, 20.0
description = read_model_description(path)
start = {variable.name: variable.start for variable in description.modelVariables}
trim = float(start["delta_e"])

# A 3-2-1-1 of the elevator, held over every communication step.
time = np.arange(0.0, STOP + STEP / 2, STEP)
edges = [(1.0, 2.5, 1), (2.5, 3.5, -1), (3.5, 4.0, 1), (4.0, 4.5, -1)]
moved = sum(sign * ((time >= a - 1e-9) & (time < b - 1e-9)) for a, b, sign in edges)
elevator = trim + 0.02 * moved

folder = extract(path)
unit = FMU3Model(guid=description.guid, unzipDirectory=folder, modelIdentifier=description.modelExchange.modelIdentifier, instanceName="rates")
unit.instantiate()
unit.enterInitializationMode()
unit.exitInitializationMode()
unit.enterContinuousTimeMode()
reference = {variable.name: variable.valueReference for variable in description.modelVariables}


def rates(state):
    unit.setContinuousStates((c_double * 12)(*state), 12)
    out = (c_double * 12)()
    unit.getContinuousStateDerivatives(out, 12)
    return np.array(out)


x = np.array([float(start[name]) for name in STATES])
own = [x]
for k in range(len(time) - 1):
    unit.setFloat64([reference["delta_e"]], [float(elevator[k])])
    for _ in range(4):
        h = STEP / 4
        k1 = rates(x)
        k2 = rates(x + k1 * h / 2)
        k3 = rates(x + k2 * h / 2)
        k4 = rates(x + k3 * h)
        x = x + (k1 + 2 * (k2 + k3) + k4) * h / 6
    own.append(x)
own = np.array(own)

slave = FMU3Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier, instanceName="flight")
slave.instantiate()


def fly():
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    flown = [slave.getFloat64([reference[name] for name in STATES])]
    for k in range(len(time) - 1):
        slave.setFloat64([reference["delta_e"]], [float(elevator[k])])
        slave.doStep(currentCommunicationPoint=float(time[k]), communicationStepSize=STEP)
        flown.append(slave.getFloat64([reference[name] for name in STATES]))
    return np.array(flown)


co = fly()
slave.reset()
again = fly()
assert np.array_equal(co, again), "a reset unit flies another flight"
scale = np.maximum(np.abs(own), 1.0)
worst = np.max(np.abs(co - own) / scale)
print(f"co-simulation against the rates of model exchange, {STOP:.0f} s: {worst:.2e}")
assert worst < 1e-9

# The thrust acting follows from setting, slope and airspeed; without the slope the setting is the thrust acting.
names = ["thrust", "airspeed", "thrust_reference", "thrust_reference_airspeed", "thrust_slope"]
thrust, airspeed, setting, at, slope = slave.getFloat64([reference[name] for name in names])
off = abs(thrust - setting - slope * (airspeed - at))
print(f"thrust acting {thrust:.1f} N at {airspeed:.2f} m/s: setting {setting:.1f} N, slope {slope:.2f} N s/m; differs by {off:.1e} N")
assert off < 1e-9 * abs(thrust) and (slope == 0.0 or abs(airspeed - at) > 1e-3), "the flight did not change the thrust"
slave.reset()
slave.setFloat64([reference["thrust_slope"], reference["thrust_reference"]], [0.0, 1234.5])
slave.enterInitializationMode()
slave.exitInitializationMode()
slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=5.0)
assert slave.getFloat64([reference["thrust"]]) == [1234.5], "without the slope the setting is not the thrust acting"
missing = [variable.name for variable in description.modelVariables if not (variable.description and variable.unit)]
assert not missing, f"without unit or description: {missing}"

exchange = simulate_fmu(path, fmi_type="ModelExchange", stop_time=1.0, output_interval=STEP, relative_tolerance=1e-10, output=STATES)
steady = np.array([[row[name] for name in STATES[:6]] for row in exchange])
print(f"model exchange by the runner's own solver, first second of the trim: speeds and rates move by {np.ptp(steady, axis=0).max():.1e}")
shutil.rmtree(folder, ignore_errors=True)
