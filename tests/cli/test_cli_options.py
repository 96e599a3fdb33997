"""Each option is stated once: keyword, flag, file key, help and recorded value follow from it."""

import inspect
import json
import re
import shlex
from dataclasses import fields
from typing import get_args, get_type_hints

import numpy as np
import pytest
import typer
import xarray as xr
from shared_definitions import DRIVEN_PENDULUM

import linkages
from linkages.cli.main import app
from linkages.components.mechanisms.registry import definition_schema
from linkages.options import run
from linkages.options.analysis_options import (
    BasinKeywords,
    BasinOptions,
    BifurcationKeywords,
    BifurcationOptions,
    EquilibriumKeywords,
    EquilibriumOptions,
    ExponentKeywords,
    ExponentOptions,
    FollowKeywords,
    FollowOptions,
    MapKeywords,
    MapOptions,
    OrbitKeywords,
    OrbitOptions,
    SectionKeywords,
    SectionOptions,
    VerdictKeywords,
    VerdictOptions,
    WearKeywords,
    WearOptions,
)
from linkages.options.option import options_in

QUESTIONS = {
    "simulate": (linkages.simulate, run.SimulationOptions, run.SimulationKeywords),
    "poincare": (linkages.poincare, SectionOptions, SectionKeywords),
    "lyapunov": (linkages.lyapunov, ExponentOptions, ExponentKeywords),
    "bifurcation": (
        linkages.bifurcation, BifurcationOptions, BifurcationKeywords
    ),
    "map": (linkages.chaos_map, MapOptions, MapKeywords),
    "basins": (linkages.basins, BasinOptions, BasinKeywords),
    "chaos": (linkages.verdict, VerdictOptions, VerdictKeywords),
    "orbit": (linkages.orbit, OrbitOptions, OrbitKeywords),
    "follow": (linkages.follow, FollowOptions, FollowKeywords),
    "equilibrium": (linkages.equilibrium, EquilibriumOptions, EquilibriumKeywords),
    "wear": (linkages.wear, WearOptions, WearKeywords),
}  # fmt: skip
ALL = [(verb, option) for verb, (_, kind, _) in QUESTIONS.items() for option in options_in(kind)]
FILE = options_in(run.SimulationOptions)
COMMANDS = typer.main.get_command(app).commands


def named(case):
    return getattr(case, "name", case)


def flag_of(verb, name):
    return next(flag for flag in COMMANDS[verb].params if flag.name == name)


@pytest.mark.parametrize("verb", COMMANDS)
def test_each_flag_has_a_help(verb):
    """A flag that a docstring misspells would have none."""
    flags = [each for each in COMMANDS[verb].params if each.param_type_name == "option"]
    assert all(flag.help for flag in flags)


@pytest.mark.parametrize("verb", COMMANDS)
def test_help_has_two_examples_that_can_be_read(verb, cli):
    examples = COMMANDS[verb].callback.examples
    assert len(examples) == 2
    for example in examples:
        program, name, *words = shlex.split(re.sub(r"\\\n| > \S+$", "", example))
        assert (program, name) == ("linkages", verb.replace("optimize", "optimise"))
        COMMANDS[verb].make_context(name, words)
    shown = cli(verb, "--help").out
    assert all(line.strip() in shown for example in examples for line in example.splitlines())


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("simulat",), "No such command 'simulat'. Did you mean 'simulate'?"),
        (("--verbos",), "linkages: 1 problem\n  No such option"),
        (("simulate",), "simulate: 1 problem\n  Missing argument 'FILE'"),
        (("simulate", "m.yaml", "--methd"), "simulate: 1 problem\n  No such option"),
    ],
)
def test_errors_of_the_command_line_read_as_those_of_files_do(words, expected, cli):
    """Versions of Click punctuate what follows in their own ways."""
    cli.refused(*words, says=expected)


@pytest.mark.parametrize(("verb", "option"), ALL, ids=named)
def test_an_option_is_a_keyword_with_its_default_and_its_meaning(verb, option):
    function, kind, keywords = QUESTIONS[verb]
    parameter = inspect.signature(function).parameters[option.name]
    assert parameter.kind is parameter.KEYWORD_ONLY
    assert parameter.default == option.default
    assert option.text
    assert f"\n{option.name}\n" in function.__doc__
    assert " ".join(option.text.split()) in " ".join(function.__doc__.split())
    # what type checkers know
    known = get_type_hints(keywords)
    assert known.keys() == {field.name for field in fields(kind)}
    word = option.value if option.value in (int, float, bool) else str
    assert word in (get_args(known[option.name]) or (known[option.name],))


@pytest.mark.parametrize(("verb", "option"), ALL, ids=named)
def test_an_option_is_a_flag_with_its_default_and_its_meaning(verb, option):
    flag = flag_of(verb, option.name)
    assert f"--{option.name.replace('_', '-')}" in flag.opts
    if (verb, option.name) != ("chaos", "periods"):  # --quick has another default
        assert getattr(flag.default, "value", flag.default) == option.default
    if (verb, option.name) not in (("chaos", "periods"), ("bifurcation", "start")):
        assert option.text.replace("`", "'").startswith(flag.help.rstrip("."))


@pytest.mark.parametrize("verb", ["animate", "phase"])
@pytest.mark.parametrize("option", options_in(run.RunOptions), ids=named)
def test_further_commands_that_integrate_have_the_flags_too(verb, option):
    assert flag_of(verb, option.name).help == flag_of("simulate", option.name).help


@pytest.mark.parametrize("option", FILE, ids=named)
def test_options_of_a_simulation_are_keys_of_the_file(option):
    """With the default of the class, and with its meaning."""
    keys = definition_schema()["definitions"]["SimulationDefaults"]["properties"]
    assert keys.keys() == {known.name for known in FILE}
    own = linkages.SimulationDefaults()
    default = getattr(run.SimulationOptions(), option.name)
    assert keys[option.name].get("default") == getattr(own, option.name) == default
    start = "Simulated time in seconds" if option.name == "end" else option.text  # no going back
    assert keys[option.name]["description"].startswith(start)


def test_help_shows_what_the_file_says_apart(cli):
    shown = cli("simulate", "--help").out
    options, _, simulation = shown.partition("Simulation (default: the section simulate")
    for option in FILE:
        flag = f"\n  --{option.name.replace('_', '-')} "
        assert flag in simulation
        assert flag not in options


def test_an_unknown_option_is_named_with_the_nearest():
    with pytest.raises(TypeError, match=r"argument 'rtoll'; did you mean 'rtol'\?"):
        linkages.lyapunov(linkages.load("pendulum"), rtoll=1e-6)


# -- they arrive -----------------------------------------------------------------------------

PENDULUM = DRIVEN_PENDULUM + "simulate: {end: 10, samples: 11, rtol: 1e-8}\n"
DAMPING, MASS = "dampers[0].damping", "masses.P"
LENGTHS = {
    "simulate": {},
    "poincare": {"periods": 3},
    "lyapunov": {"periods": 20},
    "bifurcation": {"periods": 2, "skip": 1},
    "map": {"periods": 4},
    "chaos": {"periods": 200, "skip": 10},
    "orbit": {"periods": 1, "skip": 2, "longest": 1},
    "follow": {"periods": 1, "skip": 2, "longest": 1, "points": 4},
}
RANGES = {
    "follow": {"vary": [f"{DAMPING}=0.75:0.5"]},
    "bifurcation": {"vary": f"{DAMPING}=0.5:0.6:2"},
    "map": {"x": f"{DAMPING}=0.5:0.6:2", "y": f"{MASS}=1:1.1:2"},
}
RATE = {"section": "arm.speed=0"}
PERIOD = {"indicator": "period", "periods": 60, "x": f"{DAMPING}=0.7:1:3"}
FIXED = {"method": "rk4", "step": 0.05}
RUN = {
    "method": ({"method": "tsit5"}, {"method": "vern9"}),
    "rtol": ({"rtol": 1e-6}, {"rtol": 1e-7}),
    "atol": ({"atol": 1e-6}, {"atol": 1e-5}),
    "step": (FIXED, {**FIXED, "step": 0.04}),
}
VERBS = [
    pytest.param(verb, marks=pytest.mark.slow) if verb in ("chaos", "follow") else verb
    for verb in LENGTHS
]


@pytest.fixture
def pendulum(tmp_path):
    (tmp_path / "m.yaml").write_text(PENDULUM)
    return linkages.load(tmp_path / "m.yaml")


def answered(verb, mechanism, **options):
    """What a question finds."""
    given = {**RANGES.get(verb, {}), **LENGTHS[verb], **options}
    found = QUESTIONS[verb][0](mechanism, **given)
    data = {"simulate": "data", "chaos": "exponents"}.get(verb)
    return found if data is None else getattr(found, data)


def numbers(data):
    """All of them, but when motions stopped: none does."""
    kept = [v for name, v in data.data_vars.items() if v.dtype.kind == "f" and name != "stop_time"]
    return np.concatenate([array.to_numpy().ravel() for array in kept])


@pytest.mark.slow_except("simulate-*", "lyapunov-*")
@pytest.mark.parametrize("name", RUN)
@pytest.mark.parametrize("verb", VERBS)
def test_every_question_is_integrated_as_it_is_asked(verb, name, pendulum):
    """Values of one option apart give numbers apart, of which none is missing."""
    first, second = (numbers(answered(verb, pendulum, **options)) for options in RUN[name])
    assert np.isfinite(first).all()
    assert first.shape == second.shape
    assert (first != second).any()


SEARCH = [
    ({"periods": 1}, {"periods": 2}),
    ({"skip": 1}, {"skip": 2}),
    ({"longest": 1}, {"longest": 2}),
]
SWITCHED = {"points": 16, "longest": 2}
OWN = {
    "simulate": [({"end": 5.0}, {"end": 6.0}), ({"samples": 11}, {"samples": 12})],
    "poincare": [
        ({"periods": 3}, {"periods": 4}),
        ({"skip": 0}, {"skip": 1}),
        ({"phase": 0.0}, {"phase": 0.5}),
        ({"section": "arm.speed=0"}, {"section": "arm.speed=0.1"}),
        ({**RATE, "direction": "up"}, {**RATE, "direction": "down"}),
        ({**RATE, "periods": 20, "end": 30.0}, {**RATE, "periods": 20, "end": 60.0}),
        ({"skip": 9, "wrap": True}, {"skip": 9, "wrap": False}),
    ],
    "lyapunov": [
        ({"periods": 20}, {"periods": 21}),
        ({"skip": 0}, {"skip": 2}),
        ({"count": 1}, {"count": 2}),
        ({"interval": 3.0}, {"interval": 4.0}),
    ],
    "bifurcation": [
        ({"periods": 2}, {"periods": 3}),
        ({"skip": 0}, {"skip": 1}),
        ({"phase": 0.0}, {"phase": 0.5}),
        ({"section": "arm.speed=0"}, {"section": "arm.speed=0.1"}),
        ({**RATE, "direction": "up"}, {**RATE, "direction": "down"}),
        ({**RATE, "periods": 20, "end": 30.0}, {**RATE, "periods": 20, "end": 60.0}),
        ({"skip": 9, "wrap": True}, {"skip": 9, "wrap": False}),
        ({"start": "forward"}, {"start": "backward"}),
        ({"exponent": False}, {"exponent": True}),
    ],
    "map": [
        ({"indicator": "exponent"}, {"indicator": "fli"}),
        ({"periods": 4}, {"periods": 5}),
        ({"skip": 0}, {"skip": 1}),
        ({**PERIOD, "start": "same"}, {**PERIOD, "start": "forward"}),
        ({**PERIOD, "refine": 1}, {**PERIOD, "refine": 2}),
    ],
    "orbit": [
        *SEARCH,
        ({"starts": 1}, {"starts": 4}),
        ({"starts": 4, "seed": 0}, {"starts": 4, "seed": 1}),
    ],
    "follow": [
        *SEARCH,
        ({"points": 4}, {"points": 5}),
        ({"largest_step": 0.1}, {"largest_step": 0.001}),
        ({**SWITCHED, "switch": False}, {**SWITCHED, "switch": True}),
        ({"unstable": False}, {"unstable": True}),
    ],
}
ELSEWHERE = {"follow": {"what", "starts", "seed"}}
"""Options that change nothing here: there are no equilibria, and branches begin with one orbit."""
OWN_CASES = [(verb, *pair) for verb, pairs in OWN.items() for pair in pairs]


def test_own_options_are_all_tried():
    for verb, pairs in OWN.items():
        changed = {
            name for first, second in pairs for name in second if first[name] != second[name]
        }
        own = {option.name for option in options_in(QUESTIONS[verb][1])}
        assert changed == own - set(RUN) - {"max_steps", "change_points"} - ELSEWHERE.get(
            verb, set()
        )


@pytest.mark.slow_except("simulate-*", "poincare-*", "lyapunov-*")
@pytest.mark.parametrize(("verb", "first", "second"), OWN_CASES, ids=str)
def test_own_options_change_what_is_found(verb, first, second, pendulum):
    found = [numbers(answered(verb, pendulum, **options)) for options in (first, second)]
    assert not np.array_equal(*found, equal_nan=True)


@pytest.mark.parametrize(
    ("verb", "name", "along"), [("bifurcation", "bar_angle", "value"), ("map", "indicator", "x")]
)
def test_what_the_file_says_of_the_integration_can_be_varied(verb, name, along, pendulum):
    """Options of a sweep are those of the definition at each value, unless they are given."""
    vary = "simulate.rtol=1e-8:1e-3:2"
    ranges = {"vary": vary} if verb == "bifurcation" else {"x": vary, "y": f"{MASS}=1:1.1:2"}
    varied, given = (
        QUESTIONS[verb][0](pendulum, **ranges, **LENGTHS[verb], **options)[name]
        for options in ({}, {"rtol": 1e-8})
    )
    at = {along: 0}, {along: 1}
    assert np.array_equal(varied.isel(at[0]), given.isel(at[0]))
    assert np.array_equal(given.isel(at[1]), given.isel(at[0]))
    assert (varied.isel(at[1]) != given.isel(at[0])).any()


@pytest.mark.parametrize("verb", VERBS)
def test_every_question_gives_up_after_as_many_steps_as_it_may_take(verb, pendulum):
    try:
        data = answered(verb, pendulum, max_steps=5)
    except linkages.ComputationError as error:
        reasons = [str(error)]
    else:
        reasons = data.reason.to_numpy().ravel().tolist()
    assert all("number of steps was used up" in reason for reason in reasons)


@pytest.mark.slow_except("poincare", "map")
@pytest.mark.parametrize("verb", VERBS)
def test_flags_are_keywords(verb, cli, pendulum, tmp_path):
    """A command finds what the function does, and says how: function and options give it again."""
    given = {**LENGTHS[verb], "method": "tsit5", "rtol": 2e-7, "atol": 3e-7, "max_steps": 10**5,
             "change_points": "stop"}  # fmt: skip
    flags = [f"--{name.replace('_', '-')}={value}" for name, value in given.items()]
    ranges = [
        f"--{name}={value}"
        for name, values in RANGES.get(verb, {}).items()
        for value in ([values] if isinstance(values, str) else values)
    ]
    result = cli(verb, "m.yaml", *flags, *ranges, "--no-figures", "--out", "o")
    assert result.code == 0, result.err
    file = {"chaos": "chaos_exponents"}.get(verb, verb)
    with xr.open_dataset(tmp_path / f"o/{file}.nc", engine="h5netcdf") as data:
        data.load()
    options = json.loads(data.attrs["options"])
    assert {name: options[name] for name in given} == given
    assert "tsit5" not in data.attrs["definition"]
    kept = QUESTIONS[verb][1]
    known = {option.name: options[option.name] for option in options_in(kept)}
    expected = numbers(answered(verb, pendulum, **known))
    assert np.array_equal(numbers(data), expected, equal_nan=True)


@pytest.mark.slow_except("phase")
@pytest.mark.parametrize("verb", ["animate", "phase"])
def test_films_and_curves_are_integrated_as_they_are_asked(verb, cli, pendulum):
    del pendulum
    axes = ("--x", "arm.angle", "--y", "arm.speed") if verb == "phase" else ()
    result = cli(verb, "m.yaml", *axes, "--max-steps", "5", "--out", "o")
    assert result.code == 1
    assert "number of steps was used up" in result.err


# -- what beats what -------------------------------------------------------------------------


def spans(result):
    found = json.loads(result.out)
    return found["samples"], found["method"]


@pytest.mark.slow
def test_a_flag_beats_an_assignment_and_that_the_file(cli, pendulum):
    del pendulum
    short = ("simulate", "m.yaml", "--json", "--no-figures", "--no-verify")
    own = ("--set", "simulate.samples=21", "--set", "simulate.method=tsit5")
    assert spans(cli(*short)) == (11, "dop853")
    assert spans(cli(*short, *own)) == (21, "tsit5")
    assert spans(cli(*short, *own, "--samples", "31")) == (31, "tsit5")
    assert spans(cli(*short, *own, "--samples", "31", "--method", "rk4", "--step", "10 ms")) == (
        31, "rk4",
    )  # fmt: skip


def test_a_flag_mends_what_the_file_says_wrongly(cli, pendulum):
    del pendulum
    wrong = ("simulate", "m.yaml", "--json", "--no-figures", "--set", "simulate.rtol=7")
    cli.refused(*wrong, says="simulate.rtol: rtol must be from 1e-14 to 1, found 7")
    assert cli(*wrong, "--rtol", "1e-6").code == 0


def test_flags_are_numbers_as_the_file_writes_them(cli, pendulum, tmp_path):
    del pendulum
    given = ("--end", "500 ms", "--samples", "2*5 + 1", "--rtol", "1e-3/10")
    assert cli("simulate", "m.yaml", "--no-figures", *given).code == 0
    with xr.open_dataset(tmp_path / "results/m/simulate.nc", engine="h5netcdf") as data:
        options = json.loads(data.attrs["options"])
    assert (options["end"], options["samples"], options["rtol"]) == (0.5, 11, 1e-4)


@pytest.mark.slow
def test_a_step_says_nothing_to_an_adaptive_method(cli, pendulum):
    """As a key of the file does: who changes the method back and forth leaves it there."""
    del pendulum
    short = ("simulate", "m.yaml", "--json", "--no-figures")
    plain, stepped = (json.loads(cli(*short, *more).out) for more in ((), ("--step", "1")))
    assert plain["cost"] == stepped["cost"]


@pytest.mark.slow_except("*-simulate", "*-chaos")
@pytest.mark.parametrize("verb", ["simulate", "poincare", "lyapunov", "chaos", "phase", "animate"])
@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--rtol", "2"), "--rtol: 1 problem\n  rtol must be from 1e-14 to 1, found 2"),
        (("--method", "rk4"), "--method: 1 problem\n  method 'rk4' needs a step"),
        (("--method", "euler"), "--method: 1 problem\n  unknown method 'euler'; expected one of"),
        (("--atol", "0"), "'--atol': expected a number > 0"),
        (("--step", "1 m"), "'--step': expected a time > 0"),
        (("--max-steps", "2.5"), "'--max-steps': expected a whole number > 0"),
        (("--change-points", "go"), "Invalid value for '--change-points'"),
    ],
    ids=str,
)
def test_messages_name_the_flag(verb, arguments, expected, cli, pendulum):
    del pendulum
    axes = ("--x", "arm.angle", "--y", "arm.speed") if verb == "phase" else ()
    cli.refused(verb, "m.yaml", *axes, *arguments, says=expected, files={"m.yaml"})


@pytest.mark.slow_except("phase")
@pytest.mark.parametrize("verb", ["simulate", "phase"])
def test_a_motion_back_in_time(verb, cli, pendulum):
    """What a keyword may be, a flag may: simulate goes back, a curve has no time left out."""
    del pendulum
    axes = ("--x", "arm.angle", "--y", "arm.speed") if verb == "phase" else ()
    result = cli(verb, "m.yaml", *axes, "--end", "-2")
    if verb == "simulate":
        assert result.code == 0, result.err
        assert "to t = -2 s" in result.out
    else:
        assert result.code == 2
        assert "skip must be from 0 to below -2 s" in result.err


FREE = """gravity: [0, -9.81]
joints: {O2: [0, 0], O4: [0.1, 0]}
bars:
  crank: {joints: [O2, A], length: 0.04, mass: 0.2}
  coupler: {joints: [A, B], length: 0.1, mass: 0.5}
  rocker: {joints: [O4, B], length: 0.04, mass: 0.3}
loads: [{bar: crank, torque: "1e-3*cos(2*pi*t)"}]
free: {crank: {angle: 0.5, speed: 30}}
assembly: {B: left}
simulate: {end: 1, samples: 101}
"""


FREE_CASES = {
    "simulate": (),
    "phase": ("--x", "crank.angle", "--y", "crank.speed"),
    "poincare": ("--periods", "2"),
    "bifurcation": ("--vary", "bars.crank.mass=0.2:0.3:2", "--periods", "2", "--skip", "0"),
}


@pytest.mark.slow_except("poincare")
@pytest.mark.parametrize("verb", FREE_CASES)
def test_change_points_are_passed_or_not_as_it_is_asked(verb, cli, tmp_path):
    """The free crank of a parallelogram comes to one within the first tenth of a second."""
    (tmp_path / "free.yaml").write_text(FREE)
    file = ("--set", "simulate.change_points=stop")
    for given, passes in (
        ((), True),
        (("--change-points", "stop"), False),
        (file, False),
        ((*file, "--change-points", "pass"), True),
    ):
        result = cli(verb, "free.yaml", *FREE_CASES[verb], "--no-figures", *given)
        assert ("in line; this position is singular" not in result.err + result.out) == passes
        assert result.code == 0 or not passes
