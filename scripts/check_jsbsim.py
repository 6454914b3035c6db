"""Flies the aircraft exported for JSBSim and the Functional Mock-up Unit of the same session side by side for 60 s, and prints how far apart
they end and lie at most.

    check_jsbsim.py EXPORT_FOLDER AIRCRAFT.fmu

Both start in the unit's trim and get the same doublets of elevator, aileron and rudder. The exported aircraft is given the mass, centre of
gravity, inertia and moment reference of the unit's condition, which are medians of the windows where the export has those of the start of the
first flight; the thrust of each engine acts as an external force, since the export has no engine. The unit flies over a flat Earth at rest, in an air whose density is
that of its condition and changes with altitude as the standard atmosphere's: JSBSim gets a planet of a thousand Earth radii without rotation, and
that density at every step. The gyroscopic moment of the propellers is in the unit alone."""

import json
import math
import re
import shutil
import sys
import tempfile
from pathlib import Path

import jsbsim
import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave

FOOT, POUND, SLUG = 0.3048, 4.4482216152605, 14.593902937206364
STOP, STEP, FINE = 60.0, 0.02, 0.0005
EARTH_RADIUS_M = 6.371e6 * 1000.0
# Largest differences that pass: airspeed m/s, angles and attitude rad, rates rad/s, altitude m. A control that jumps acts one step of 0.5 ms later in
# JSBSim, which the rates show.
LIMITS = {"airspeed": 1e-3, "alpha": 1e-4, "beta": 1e-4, "p": 3e-4, "q": 3e-4, "r": 3e-4, "phi": 1e-4, "theta": 1e-4, "psi": 1e-4, "h": 1e-2}


def controls(time, trim):
    """Aileron, elevator and rudder: a doublet each, the aircraft free for the rest."""

    def doublet(start, half, size):
        return size * ((start <= time < start + half) - (start + half <= time < start + 2 * half))

    return [trim[0] + doublet(20.0, 1.0, 0.05), trim[1] + doublet(2.0, 0.8, 0.05), trim[2] + doublet(38.0, 1.0, 0.05)]


def standard_density(altitude_m):
    """Density of the standard atmosphere up to 11 km, kg/m3."""
    temperature = 288.15 - 0.0065 * altitude_m
    return 1.225 * (temperature / 288.15) ** (9.80665 / (287.05287 * 0.0065) - 1.0)


def fly_unit(path):
    description = read_model_description(path)
    folder = extract(path)
    model = json.loads((Path(folder) / "resources" / "model.json").read_text())
    reference = {variable.name: variable.valueReference for variable in description.modelVariables}
    unit = FMU3Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier, instanceName="flight")
    unit.instantiate()
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    names = list(LIMITS)
    flown = [unit.getFloat64([reference[name] for name in names])]
    for k in range(round(STOP / STEP)):
        unit.setFloat64([reference[name] for name in ("delta_a", "delta_e", "delta_r")], controls(k * STEP, model["input"]))
        unit.doStep(currentCommunicationPoint=k * STEP, communicationStepSize=STEP)
        flown.append(unit.getFloat64([reference[name] for name in names]))
    # The thrust that the unit states is the one that the exported aircraft is given.
    condition = model["condition"]
    thrust, airspeed = unit.getFloat64([reference["thrust"], reference["airspeed"]])
    expected = model["input"][3] + condition["thrust_slope_n_s_m"] * (airspeed - condition["airspeed_m_s"])
    assert abs(thrust - expected) < 1e-9 * abs(expected), (thrust, expected)
    unit.terminate()
    shutil.rmtree(folder, ignore_errors=True)
    return model, np.array(flown)


def prepare(export, work, model):
    """The exported aircraft with the unit's mass properties and engines, and a large planet at rest."""
    (source,) = [path for path in Path(export).iterdir() if path.is_dir()]
    name = source.name
    shutil.copytree(source, work / name)
    path = work / name / f"{name}.xml"
    text = path.read_text()
    condition = model["condition"]
    inertia = [[value / (SLUG * FOOT**2) for value in row] for row in condition["inertia_kg_m2"]]

    def point(location, datum):
        nonlocal text
        inches = [f"<{axis}>{value / 0.0254!r}</{axis}>" for axis, value in zip("xyz", datum)]
        pattern = rf'(<location name="{location}" unit="IN">).*?(</location>)'
        text, count = re.subn(pattern, lambda found: found[1] + "".join(inches) + found[2], text, flags=re.S)
        assert count == 1, location

    point("CG", condition["cg_from_datum_m"])
    moment = model["moment_reference"] or {"datum_m": condition["cg_from_datum_m"]}
    point("AERORP", moment["datum_m"])
    # Products of inertia stand in the matrix with a negative sign.
    numbers = {"ixx": inertia[0][0], "iyy": inertia[1][1], "izz": inertia[2][2]}
    numbers |= {"ixy": -inertia[0][1], "ixz": -inertia[0][2], "iyz": -inertia[1][2]}
    numbers["emptywt"] = condition["mass_kg"] / 0.45359237
    for tag, value in numbers.items():
        text, count = re.subn(rf"(<{tag}[^>]*>)[^<]*", lambda found: f"{found[1]}{value!r}", text)
        assert count == 1, tag
    forces = ""
    for index, engine in enumerate(model["engines"]):
        where = [f"<{axis}>{value / 0.0254!r}</{axis}>" for axis, value in zip("xyz", engine["position"]["datum_m"])]
        along = [f"<{axis}>{value!r}</{axis}>" for axis, value in zip("xyz", engine["direction_body"])]
        forces += f'<force name="thrust{index}" frame="BODY"><location unit="IN">{"".join(where)}</location><direction>{"".join(along)}</direction></force>'
    text = text.replace("<propulsion/>", f"<external_reactions>{forces}</external_reactions><propulsion/>")
    path.write_text(text)
    radius = EARTH_RADIUS_M / FOOT
    gravitation = condition["gravity_m_s2"] / FOOT * radius**2
    planet = work / "planet.xml"
    planet.write_text(
        f'<?xml version="1.0"?><planet name="flat"><semimajor_axis unit="FT">{radius!r}</semimajor_axis><semiminor_axis unit="FT">{radius!r}</semiminor_axis>'
        f'<rotation_rate unit="RAD/SEC">0.0</rotation_rate><GM unit="FT3/SEC2">{gravitation!r}</GM><J2>0.0</J2></planet>'
    )
    return name, planet


def fly_jsbsim(export, model):
    work = Path(tempfile.mkdtemp())
    name, planet = prepare(export, work, model)
    jsbsim.FGJSBBase().debug_lvl = 0
    flight = jsbsim.FGFDMExec(str(work))
    flight.set_debug_level(0)
    flight.set_dt(FINE)
    assert flight.load_planet(str(planet), False)
    flight.set_aircraft_path(str(work))
    flight.set_engine_path(str(work))
    flight.set_systems_path(str(work))
    assert flight.load_model(name)
    u, v, w, p, q, r, phi, theta, psi, _, _, altitude = model["state"]
    # Fourth-order steps: Adams and Bashforth's third-order integrators everywhere.
    for which in ("rate/rotational", "rate/translational", "position/rotational", "position/translational"):
        flight[f"simulation/integrator/{which}"] = 4
    start = {"lat-geod-deg": 0.0, "long-gc-deg": 0.0, "h-sl-ft": altitude / FOOT, "terrain-elevation-ft": 0.0, "phi-rad": phi, "theta-rad": theta, "psi-true-rad": psi}
    start |= {"u-fps": u / FOOT, "v-fps": v / FOOT, "w-fps": w / FOOT, "p-rad_sec": p, "q-rad_sec": q, "r-rad_sec": r}
    for key, value in start.items():
        flight[f"ic/{key}"] = value
    condition = model["condition"]
    thrust = model["input"][3]

    def hold(time):
        aileron, elevator, rudder = controls(time, model["input"])
        flight["fcs/right-aileron-pos-rad"], flight["fcs/elevator-pos-rad"], flight["fcs/rudder-pos-rad"] = aileron, elevator, rudder
        airspeed = flight["velocities/vt-fps"] * FOOT
        total = thrust + condition["thrust_slope_n_s_m"] * (airspeed - condition["airspeed_m_s"]) if started else thrust
        for index, engine in enumerate(model["engines"]):
            flight[f"external_reactions/thrust{index}/magnitude"] = total * engine["share"] / POUND
        height = flight["position/h-sl-ft"] * FOOT if started else altitude
        density = condition["density_kg_m3"] * standard_density(height) / standard_density(condition["altitude_m"])
        flight["atmosphere/override/density"] = density / (SLUG / FOOT**3)

    started = False
    hold(0.0)
    assert flight.run_ic()
    started = True
    columns = {"airspeed": ("velocities/vt-fps", FOOT), "alpha": ("aero/alpha-rad", 1.0), "beta": ("aero/beta-rad", 1.0)}
    columns |= {axis: (f"velocities/{axis}-rad_sec", 1.0) for axis in "pqr"}
    columns |= {"phi": ("attitude/phi-rad", 1.0), "theta": ("attitude/theta-rad", 1.0), "psi": ("attitude/psi-rad", 1.0), "h": ("position/h-sl-ft", FOOT)}

    def row():
        return [flight[key] * factor for key, factor in (columns[name] for name in LIMITS)]

    flown = [row()]
    for k in range(round(STOP / STEP)):
        for _ in range(round(STEP / FINE)):
            hold(k * STEP)
            flight.run()
        flown.append(row())
    shutil.rmtree(work, ignore_errors=True)
    return np.array(flown)


def main():
    model, own = fly_unit(sys.argv[2])
    other = fly_jsbsim(sys.argv[1], model)
    names = list(LIMITS)
    heading = names.index("psi")
    other[:, heading] = (other[:, heading] - own[:, heading] + math.pi) % (2 * math.pi) - math.pi + own[:, heading]
    apart = np.abs(other - own)
    print(f"{'':10}{'moves by':>12}{'at most':>12}{'at the end':>12}{'limit':>10}")
    for column, name in enumerate(names):
        print(f"{name:10}{np.ptp(own[:, column]):12.3g}{apart[:, column].max():12.2e}{apart[-1, column]:12.2e}{LIMITS[name]:10.0e}")
    over = [name for column, name in enumerate(names) if not apart[:, column].max() < LIMITS[name]]
    assert not over, f"further apart than stated: {over}"


main()
