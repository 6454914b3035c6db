"""Writes the shipped flight as a stranger makes a session of it: climb rate taken for sink rate, knots for m/s, a late elevator.

usage: python3 tests/ui_real/spoilt.py FOLDER
"""

import pathlib
import re
import sys

root = pathlib.Path(__file__).resolve().parents[2]
folder = pathlib.Path(sys.argv[1])
roles = (root / "assets/channel_maps/demo_flight.toml").read_text()
roles = re.sub(r'(\[roles\.v_down\][^\[]*?)\nsign = -1\.0', r"\1", roles)
roles = re.sub(r'(\[roles\.airspeed\][^\[]*?unit = )"kt"', r'\1"m/s"', roles)
session = (root / "sessions/demo.toml").read_text()
session = session.replace('channel_map = "builtin:demo_flight"', 'channel_map = "map.toml"')
late = "[preparation.control_lag]\nelevator = { delay_s = 0.1 }\n\n"
session = session.replace("[[flight]]", late + "[[flight]]", 1)
(folder / "map.toml").write_text(roles)
(folder / "session.toml").write_text(session)
