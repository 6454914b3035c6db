"""Flies an exported aircraft through points with JSBSim: jsbsim_points.py AIRCRAFT_PATH NAME POINTS.json RESULTS.json

A point is a table of properties in JSBSim's units: initial conditions under "initial", deflections under "controls". The result
of a point is every property listed in the file's "read".
"""

import json
import sys

import jsbsim

aircraft_path, name, points_file, results_file = sys.argv[1:5]
with open(points_file) as file:
    task = json.load(file)

fdm = jsbsim.FGFDMExec(None)
fdm.set_debug_level(0)
fdm.set_aircraft_path(aircraft_path)
if not fdm.load_model(name):
    sys.exit("JSBSim did not load " + name)

results = []
for point in task["points"]:
    for key, value in point["initial"].items():
        fdm[key] = value
    if not fdm.run_ic():
        sys.exit("JSBSim refused the initial conditions")
    fdm.suspend_integration()
    for key, value in point["controls"].items():
        fdm[key] = value
    fdm.run()
    results.append([fdm[key] for key in task["read"]])
    fdm.resume_integration()

with open(results_file, "w") as file:
    json.dump(results, file)
