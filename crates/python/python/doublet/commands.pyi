"""One function for each command of the command line. Written by scripts/python_commands.py."""

from typing import Literal, Optional

from ._commands import Answer, Input, Many

__all__ = [
    "Answer", "aircraft_list", "aircraft_new", "aircraft_show", "batch", "calibrate", "campaign", "check", "checks", "compare",
    "compatibility", "completions", "coverage", "datcom", "debrief", "design", "diff", "engine", "enough", "equations",
    "export", "fidelity", "fix", "fmu", "help", "inspect", "lags", "linear", "live", "loes", "man", "manoeuvres", "map",
    "match", "modes", "monte_carlo", "new", "prior", "propagate", "propose_manoeuvres", "propose_noise", "propose_onsets",
    "propose_steady", "qtg", "qualities", "regress", "report", "response", "run", "schema", "sensitivity", "simulate",
    "static_thrust", "structure", "swing", "tune", "variants", "weigh",
]

def inspect(recording: Input, *, map: Optional[Input] = ...) -> Answer: ...
def map(
    recordings: Optional[Many] = ..., *, write: Optional[Input] = ..., list: bool = ..., show: Optional[Input] = ..., role:
    Optional[Many] = ..., time: Optional[Many] = ...,
) -> Answer: ...
def new(
    recordings: Many, *, output: Input, map: Optional[Input] = ..., guess: bool = ..., role: Optional[Many] = ..., time:
    Optional[Many] = ..., aircraft: Optional[Input] = ..., area: Optional[Input] = ..., span: Optional[Input] = ..., chord:
    Optional[Input] = ..., mass: Optional[Input] = ..., inertia: Optional[Input] = ..., class_: Optional[Input] = ..., length:
    Optional[Input] = ..., merge: bool = ..., structure: Optional[Literal["thesis", "alternative", "quadratic", "with-power"]] =
    ...,
) -> Answer: ...
def aircraft_list() -> Answer: ...
def aircraft_show(name: Input) -> Answer: ...
def aircraft_new(
    name: Input, *, output: Input, area: Optional[Input] = ..., span: Optional[Input] = ..., chord: Optional[Input] = ..., mass:
    Optional[Input] = ..., inertia: Optional[Input] = ..., class_: Optional[Input] = ..., length: Optional[Input] = ...,
) -> Answer: ...
def check(file: Input) -> Answer: ...
def run(
    session: Input, *, out: Input, with_: Optional[Many] = ..., tables: Optional[Many] = ..., histories: Optional[Many] = ...,
    recordings: bool = ..., strict: bool = ..., verbose: bool = ...,
) -> Answer: ...
def report(
    session: Input, *, out: Optional[Input] = ..., format: Optional[Many] = ..., sections: Optional[Many] = ..., style:
    Optional[Input] = ..., no_appendix: bool = ..., prior: Optional[Input] = ..., class_: Optional[Literal["I", "II", "II-L",
    "II-C", "III", "IV"]] = ..., category: Optional[Literal["A", "B", "C"]] = ..., stick_delay: Optional[Input] = ..., aileron:
    Optional[Input] = ..., limits: Optional[Literal["mil_f_8785c", "mil_std_1797a"]] = ...,
) -> Answer: ...
def sensitivity(session: Input, *, out: Optional[Input] = ...) -> Answer: ...
def manoeuvres(session: Input, *, out: Optional[Input] = ...) -> Answer: ...
def checks(session: Input, *, out: Optional[Input] = ..., axis: Optional[Input] = ..., with_: Optional[Many] = ...) -> Answer: ...
def lags(session: Input, *, out: Optional[Input] = ..., take: Optional[Many] = ...) -> Answer: ...
def live(
    *, file: Optional[Input] = ..., udp: Optional[Input] = ..., mavlink: Optional[Input] = ..., from_: Optional[Many] = ...,
    session: Optional[Input] = ..., map: Optional[Input] = ..., aircraft: Optional[Input] = ..., speed: Optional[Input] = ...,
    every: Optional[Input] = ..., latency: Optional[Input] = ..., forget: Optional[Input] = ..., goal: Optional[Many] = ...,
    limit: Optional[Many] = ..., campaign: Optional[Input] = ..., record: Optional[Input] = ..., wait: Optional[Input] = ...,
    for_: Optional[Input] = ...,
) -> Answer: ...
def compatibility(
    session: Input, *, free: Optional[Many] = ..., per_manoeuvre: Optional[Many] = ..., outputs: Optional[Many] = ..., wind:
    bool = ..., method: Optional[Literal["output-error", "filter-error"]] = ..., manoeuvres: Optional[Many] = ..., take: bool =
    ...,
) -> Answer: ...
def structure(
    session: Input, *, method: Optional[Literal["stepwise", "orthogonal"]] = ..., terms: Optional[Many] = ...,
) -> Answer: ...
def regress(
    table: Input, *, y: Input, terms: Input, dt: Optional[Input] = ..., deviations: Optional[Input] = ..., method:
    Optional[Literal["all", "stepwise", "orthogonal"]] = ..., out: Optional[Input] = ...,
) -> Answer: ...
def equations(
    table: Input, *, equations: Input, column: Optional[Many] = ..., constant: Optional[Many] = ..., time: Optional[Input] =
    ..., dt: Optional[Input] = ..., window: Optional[Many] = ..., half_width: Optional[Input] = ..., piece: Optional[Input] =
    ...,
) -> Answer: ...
def response(
    source: Input, *, input: Input, output: Input, manoeuvres: Optional[Many] = ..., band: Optional[Input] = ..., window_length:
    Optional[Many] = ..., overlap: Optional[Input] = ..., points: Optional[Input] = ..., dt: Optional[Input] = ..., out:
    Optional[Input] = ..., figure: Optional[Input] = ...,
) -> Answer: ...
def loes(
    source: Input, *, input: Input, output: Input, form: Input, manoeuvres: Optional[Many] = ..., band: Optional[Input] = ...,
    window_length: Optional[Many] = ..., overlap: Optional[Input] = ..., points: Optional[Input] = ..., dt: Optional[Input] =
    ..., out: Optional[Input] = ..., figure: Optional[Input] = ..., method: Optional[Literal["output-error", "coherence"]] =
    ..., delay: Optional[Input] = ..., limits: Optional[Input] = ..., class_: Optional[Literal["I", "II", "II-L", "II-C", "III",
    "IV"]] = ..., category: Optional[Literal["A", "B", "C"]] = ...,
) -> Answer: ...
def variants(
    session: Input, *, know: Optional[Many] = ..., noise: Optional[Many] = ..., order: Optional[Input] = ...,
) -> Answer: ...
def monte_carlo(
    session: Input, *, out: Optional[Input] = ..., realisations: Optional[Input] = ..., seed: Optional[Input] = ...,
) -> Answer: ...
def compare(session: Input, *, with_: Optional[Many] = ..., output: Optional[Input] = ...) -> Answer: ...
def fix(session: Input, *, most: Optional[Input] = ..., apply: Optional[Many] = ..., output: Optional[Input] = ...) -> Answer: ...
def propose_manoeuvres(session: Input, *, apply: bool = ..., least_dynamic_pressure: Optional[Input] = ...) -> Answer: ...
def propose_steady(session: Input, *, apply: bool = ..., least_dynamic_pressure: Optional[Input] = ...) -> Answer: ...
def propose_onsets(session: Input, *, apply: bool = ..., least_dynamic_pressure: Optional[Input] = ...) -> Answer: ...
def propose_noise(session: Input, *, apply: bool = ..., least_dynamic_pressure: Optional[Input] = ...) -> Answer: ...
def match(session: Input, *, tolerances: Optional[Input] = ..., percent: Optional[Literal["range", "sample"]] = ...) -> Answer: ...
def qtg(
    session: Input, *, tests: Input, out: Input, constants: Optional[Literal["identification", "refit"]] = ..., format:
    Optional[Many] = ...,
) -> Answer: ...
def fmu(
    session: Input, *, out: Input, airspeed: Optional[Input] = ..., altitude: Optional[Input] = ..., gamma: Optional[Input] =
    ..., load_factor: Optional[Input] = ..., pull_up: bool = ..., mass: Optional[Input] = ..., cg: Optional[Input] = ..., fuel:
    Optional[Input] = ..., manoeuvre: Optional[Input] = ..., samples: Optional[Input] = ..., seed: Optional[Input] = ...,
) -> Answer: ...
def prior(
    session: Input, *, prior: Input, relative: Optional[Input] = ..., alpha_deg: Optional[Input] = ..., aircraft:
    Optional[Input] = ...,
) -> Answer: ...
def linear(
    session: Input, *, airspeed: Optional[Input] = ..., altitude: Optional[Input] = ..., gamma: Optional[Input] = ...,
    load_factor: Optional[Input] = ..., pull_up: bool = ..., mass: Optional[Input] = ..., cg: Optional[Input] = ..., fuel:
    Optional[Input] = ..., manoeuvre: Optional[Input] = ..., samples: Optional[Input] = ..., seed: Optional[Input] = ..., out:
    Optional[Input] = ...,
) -> Answer: ...
def modes(
    session: Input, *, airspeed: Optional[Input] = ..., altitude: Optional[Input] = ..., gamma: Optional[Input] = ...,
    load_factor: Optional[Input] = ..., pull_up: bool = ..., mass: Optional[Input] = ..., cg: Optional[Input] = ..., fuel:
    Optional[Input] = ..., manoeuvre: Optional[Input] = ..., samples: Optional[Input] = ..., seed: Optional[Input] = ..., locus:
    Optional[Input] = ...,
) -> Answer: ...
def qualities(
    session: Input, *, airspeed: Optional[Input] = ..., altitude: Optional[Input] = ..., gamma: Optional[Input] = ...,
    load_factor: Optional[Input] = ..., pull_up: bool = ..., mass: Optional[Input] = ..., cg: Optional[Input] = ..., fuel:
    Optional[Input] = ..., manoeuvre: Optional[Input] = ..., samples: Optional[Input] = ..., seed: Optional[Input] = ...,
    class_: Optional[Literal["I", "II", "II-L", "II-C", "III", "IV"]] = ..., category: Optional[Literal["A", "B", "C"]] = ...,
    stick_delay: Optional[Input] = ..., aileron: Optional[Input] = ..., limits: Optional[Literal["mil_f_8785c",
    "mil_std_1797a"]] = ...,
) -> Answer: ...
def design(
    session: Input, *, surfaces: Optional[Many] = ..., criterion: Optional[Literal["d", "a", "max-relative"]] = ..., peak:
    Optional[Input] = ..., rate: Optional[Input] = ..., peak_thrust: Optional[Input] = ..., limit: Optional[Many] = ..., usage:
    Optional[Input] = ..., gusts: Optional[Input] = ..., airspeed: Optional[Input] = ..., altitude: Optional[Input] = ..., fuel:
    Optional[Input] = ..., seed: Optional[Input] = ..., time: Optional[Input] = ..., kind: Optional[Input] = ..., rounds:
    Optional[Input] = ..., samples: Optional[Input] = ..., with_flown: bool = ..., compare: bool = ..., out: Optional[Input] =
    ..., style: Optional[Input] = ..., format: Optional[Many] = ..., travel: Optional[Input] = ...,
) -> Answer: ...
def campaign(
    campaign: Input, *, session: Optional[Input] = ..., out: Optional[Input] = ..., format: Optional[Many] = ..., style:
    Optional[Input] = ...,
) -> Answer: ...
def weigh(weighing: Input, *, session: Optional[Input] = ...) -> Answer: ...
def swing(swing: Input) -> Answer: ...
def static_thrust(test: Input) -> Answer: ...
def debrief(
    design: Input, *, flight: Optional[Many] = ..., session: Optional[Input] = ..., out: Optional[Input] = ..., format:
    Optional[Many] = ...,
) -> Answer: ...
def enough(
    session: Input, *, surfaces: Optional[Many] = ..., criterion: Optional[Literal["d", "a", "max-relative"]] = ..., peak:
    Optional[Input] = ..., rate: Optional[Input] = ..., peak_thrust: Optional[Input] = ..., limit: Optional[Many] = ..., usage:
    Optional[Input] = ..., gusts: Optional[Input] = ..., airspeed: Optional[Input] = ..., altitude: Optional[Input] = ..., fuel:
    Optional[Input] = ..., seed: Optional[Input] = ..., goal: Optional[Many] = ..., goal_percent: Optional[Input] = ..., time:
    Optional[Input] = ...,
) -> Answer: ...
def propagate(session: Input, expression: Input, *, samples: Optional[Input] = ..., seed: Optional[Input] = ...) -> Answer: ...
def export(session: Input, *, out: Input, format: Optional[Many] = ...) -> Answer: ...
def diff(first: Input, second: Input, *, settings: bool = ...) -> Answer: ...
def batch(sessions: Input, *, out: Input, task: Optional[Input] = ...) -> Answer: ...
def coverage(
    session: Optional[Input] = ..., *, scenario: Optional[Input] = ..., gusts: Optional[Input] = ..., realisations:
    Optional[Input] = ..., seed: Optional[Input] = ..., recorded: bool = ..., verdict: bool = ..., modes: bool = ..., design:
    Optional[Input] = ..., known: Optional[Input] = ..., surfaces: Optional[Many] = ..., time: Optional[Input] = ...,
) -> Answer: ...
def calibrate(
    session: Optional[Input] = ..., *, scenario: Optional[Input] = ..., realisations: Optional[Input] = ..., seed:
    Optional[Input] = ...,
) -> Answer: ...
def fidelity(*, out: Input, realisations: Optional[Input] = ...) -> Answer: ...
def schema(file: Literal["session", "channel-map", "aircraft", "instruments", "sweep", "equations"]) -> Answer: ...
def simulate(
    scenario: Optional[Input] = ..., *, out: Optional[Input] = ..., seed: Optional[Input] = ..., derivative: Optional[Many] =
    ..., amplitude: Optional[Input] = ..., airspeed_kt: Optional[Input] = ..., altitude_ft: Optional[Input] = ..., list: bool =
    ...,
) -> Answer: ...
def engine(
    aircraft: Input, *, rpm: Input, manifold_inhg: Input, altitude_ft: Input, oat_c: Input, airspeed_kt: Input, step_percent:
    Optional[Input] = ..., thesis_density: bool = ...,
) -> Answer: ...
def tune(
    session: Input, *, manoeuvres: Optional[Many] = ..., method: Optional[Literal["quasi-newton", "em"]] = ..., steps:
    Optional[Input] = ..., delay: Optional[Many] = ..., range: Optional[Input] = ...,
) -> Answer: ...
def datcom(
    listing: Optional[Input] = ..., *, aircraft: Optional[Input] = ..., results: Optional[Input] = ..., alpha_deg:
    Optional[Many] = ..., deck: Optional[Input] = ..., output: Optional[Input] = ..., mach: Optional[Input] = ..., altitude_m:
    Optional[Input] = ...,
) -> Answer: ...
def help(topic: Optional[Many] = ..., *, search: Optional[Input] = ..., term: Optional[Input] = ...) -> Answer: ...
def completions(shell: Literal["bash", "elvish", "fish", "powershell", "zsh"]) -> Answer: ...
def man(*, out: Input) -> Answer: ...
