"""Units of the Functional Mock-up Interface against FMPy's rules and `linkages.simulate`."""

import ctypes
import io
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest

import linkages
from linkages.exports import Subject, files_of
from linkages.options.option import OptionError

fmpy = pytest.importorskip("fmpy")
if shutil.which("gcc") is None:
    pytest.skip("needs gcc on the PATH", allow_module_level=True)

from exported_states import (  # noqa: E402
    CHANGES,
    NAMES,
    PARALLELOGRAM,
    PASSING,
    SWITCHED,
    kernel,
    system,
)
from exported_units import (  # noqa: E402
    channel,
    differences,
    end_of,
    get,
    instance,
    put,
    references,
    start,
    unit_of,
    unpacked,
    written,
)
from fmpy.fmi1 import FMICallException  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

VERSIONS = ("3.0", "2.0")
FOLLOWED = ("joint_position", "slider_position")
"""Outputs that are compared to the last digits; others are up to 1e4 times as sensitive."""
STRICT = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wno-unused-parameter"]
FEW = ("four-bar", "rub", "slider-crank-contact")


@pytest.mark.slow_except("3.0-rub", "2.0-four-bar")
@pytest.mark.parametrize("name", [*NAMES, *PASSING])
@pytest.mark.parametrize("version", VERSIONS)
def test_descriptions_follow_the_schemas_and_rules_of_fmpy(version, name):
    path = written(name, version)
    assert validate_fmu(str(path)) == []
    if version == "3.0":
        from lxml import etree

        schema = Path(fmpy.__file__).parent / "schema/fmi3/fmi3BuildDescription.xsd"
        with zipfile.ZipFile(path) as archive:
            build = etree.fromstring(archive.read("sources/buildDescription.xml"))
        etree.XMLSchema(file=str(schema)).assertValid(build)


@pytest.mark.slow_except("3.0-rub", "2.0-bounce")
@pytest.mark.parametrize("name", [*FEW, "bounce", "wound"])
@pytest.mark.parametrize("version", VERSIONS)
def test_sources_are_strict_c99_and_take_a_prefix(version, name, tmp_path):
    with zipfile.ZipFile(written(name, version)) as archive:
        (tmp_path / "unit.c").write_bytes(archive.read("sources/unit.c"))
    macro = f"FMI{version[0]}_FUNCTION_PREFIX"
    options = ["-O0", f"-D{macro}=alone_", "-shared", "-fPIC", "unit.c", "-o", "unit.so", "-lm"]
    subprocess.run([*STRICT, *options], cwd=tmp_path, check=True)
    version_of = getattr(ctypes.CDLL(str(tmp_path / "unit.so")), f"alone_fmi{version[0]}GetVersion")
    version_of.restype = ctypes.c_char_p
    assert version_of() == version.encode()


@pytest.mark.slow_except("3.0")
@pytest.mark.parametrize("version", VERSIONS)
def test_functions_are_those_of_the_official_headers(version, tmp_path):
    """By name and prototype, as the headers that FMPy ships declare them; statuses are numbers."""
    major, folder = version[0], Path(fmpy.__file__).parent / "c-code"
    for file in folder.glob(f"fmi{major}*.h"):
        text = file.read_text(encoding="utf-8")
        text = re.sub(r"typedef enum\s*\{[^}]*\}\s*(\w+);", r"typedef int \1;", text)
        # structures of other names
        text = re.sub(r"FMI2_Export \w+\s+fmi2(Instantiate|NewDiscreteStates);", "", text)
        (tmp_path / file.name).write_text(text, encoding="utf-8")
        names = set(re.findall(r"_Export.*?(fmi\d\w+);", file.read_text(encoding="utf-8")))
        if names:
            library = next(Path(unpacked(written("rub", version))[1]).glob("binaries/*/*"))
            assert all(hasattr(ctypes.CDLL(str(library)), name) for name in names)
    with zipfile.ZipFile(written("rub", version)) as archive:
        (tmp_path / "unit.c").write_bytes(archive.read("sources/unit.c"))
    both = f'#include "fmi{major}Functions.h"\n#include "unit.c"\n'
    (tmp_path / "both.c").write_text(both, encoding="utf-8")
    subprocess.run(["gcc", "-std=c99", "-fsyntax-only", "both.c"], cwd=tmp_path, check=True)


def run(name, kind, rtol, version="3.0", steps=30, **options):
    """What FMPy makes of a motion: a table, and times."""
    path, end = written(name, version), end_of(name)
    table = fmpy.simulate_fmu(
        str(path), fmi_type=kind, stop_time=end, output_interval=end / steps,
        relative_tolerance=rtol, record_events=False, output=channel(path, "output"), **options,
    )  # fmt: skip
    times = np.linspace(0.0, end, steps + 1)
    np.testing.assert_allclose(table["time"], times, rtol=0, atol=1e-12)
    return table, times


@pytest.mark.slow_except("3.0-four-bar", "3.0-bounce", "2.0-rub", "3.0-stick")
@pytest.mark.parametrize("name", [*NAMES, *PASSING])
@pytest.mark.parametrize("version", VERSIONS)
def test_co_simulation_is_the_motion_of_simulate(version, name):
    """All outputs, through contacts, friction and change points."""
    found = differences(name, *run(name, "CoSimulation", 1e-12, version))
    for variable, error in found.items():
        assert error < (1e-9 if variable in FOLLOWED else 1e-6), variable


STIFF = ("rigid", "impact-oscillator", "idling-engine")
SMOOTH = ("double-pendulum", "five-bar-free", "tables", "andrews")


@pytest.mark.slow_except("3.0-bounce", "3.0-rub", "2.0-four-bar")
@pytest.mark.parametrize("name", [*SMOOTH, *SWITCHED, *STIFF, "four-bar"])
@pytest.mark.parametrize("version", VERSIONS)
def test_model_exchange_is_the_motion_of_simulate_to_the_error_of_the_master(version, name):
    """CVODE's error at a tolerance is at most what a hundred times the tolerance changes."""
    coarse, times = run(name, "ModelExchange", 1e-8, version, steps=300)
    fine, _ = run(name, "ModelExchange", 1e-10, version, steps=300)
    found = differences(name, fine, times)
    sizes = {
        variable: max(
            np.abs(fine[q.name] - coarse[q.name]).max() / max(1.0, np.abs(fine[q.name]).max())
            for q in kernel(name).quantities
            if q.variable == variable and q.name in fine.dtype.names
        )
        for variable in FOLLOWED
        if variable in found
    }
    for variable, change in sizes.items():
        assert found[variable] < change + 1e-9
    assert all(change < 1e-4 for change in sizes.values())


@pytest.mark.slow_except("rub")
@pytest.mark.parametrize("name", [*SWITCHED, "impact-oscillator"])
def test_masters_that_locate_no_events_make_errors_of_the_order_of_their_steps(name):
    """Euler's method, whose events are seen at the ends of steps; a tenth of the step, a tenth."""
    path, end, found = written(name), end_of(name), []
    for steps in (3000, 30000):
        table = fmpy.simulate_fmu(
            str(path), fmi_type="ModelExchange", solver="Euler", stop_time=end,
            step_size=end / steps, output_interval=end / steps, record_events=False,
            output=channel(path, "output"),
        )  # fmt: skip
        times = np.linspace(0.0, end, 31)
        found.append(differences(name, table[:: steps // 30], times)["joint_position"])
    assert found[1] < 0.3 * found[0] < 0.03


@pytest.mark.slow_except("driven")
@pytest.mark.parametrize("name", ["free", "driven"])
def test_communication_points_near_change_points_show_the_same_motion(name):
    """Past three of them, the way through does not depend on where a master asks; half of the
    digits of a position are left in line."""
    table, times = run(name, "CoSimulation", 1e-12, steps=2000)
    for axis in "xy":
        angle = table["a.angle"]
        expected = 1 + 0.5 * np.cos(angle) if axis == "x" else 0.5 * np.sin(angle)
        near = np.abs(table[f"B.{axis} position"] - expected)  # bars a and c stay parallel
        assert near.max() < 1e-7
    assert differences(name, table, times)["bar_angle"] < 1e-6
    assert differences(name, table[::100], times[::100])["joint_position"] < 1e-9


def test_model_exchange_ends_at_change_points_with_the_joint():
    """Where the definition does not say that drives lead through."""
    path, said = unit_of(PARALLELOGRAM), []
    with instance(path, "exchange", said) as unit:
        start(unit, path=path)
        unit.updateDiscreteStates()
        unit.enterContinuousTimeMode()
        unit.setTime(0.1)
        assert unit.completedIntegratorStep() == (False, False)
        unit.setTime(0.3)
        with pytest.raises(FMICallException):
            unit.completedIntegratorStep()
    assert "joint B, block 0" in said[0]
    (time,) = re.findall(r"t = ([\d.]+) s", said[0])
    assert float(time) == pytest.approx(CHANGES, abs=1e-5)  # π/3 rad at 6 rad/s


NEUTRAL = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1, 0]}
bars:
  a: {joints: [O, A], length: 0.4, mass: 1}
  b: {joints: [A, B], length: 0.9, mass: 1}
  c: {joints: [C, B], length: 0.5, mass: 1}
free: {a: {angle: 60 deg, speed: -14}}
assembly: {B: [1.1, 0.45]}
simulate: {end: 0.4, samples: 21}
"""
"""The shortest and the longest bar are as long as the others: all are in line once."""


@pytest.mark.slow_except("3.0-free", "2.0-neutral")
@pytest.mark.parametrize("name", ["free", "driven", "neutral"])
@pytest.mark.parametrize("version", VERSIONS)
def test_model_exchange_passes_change_points_as_simulate_does(version, name):
    """Three of them, two by drives, and one; to the error of the master at 1e-12."""
    if name == "neutral":
        mechanism, end = linkages.loads(NEUTRAL), 0.4
        path = unit_of(NEUTRAL, version)
    else:
        mechanism, end, path = system(name).mechanism, end_of(name), written(name, version)
    table = fmpy.simulate_fmu(
        str(path), fmi_type="ModelExchange", stop_time=end, output_interval=end / 20,
        relative_tolerance=1e-12, record_events=False,
    )  # fmt: skip
    data = linkages.simulate(mechanism, times=np.linspace(0.0, end, 21), rtol=1e-12).data
    for bar in "abc":
        difference = table[f"{bar}.angle"] - data.bar_angle.sel(bar=bar).values
        apart = np.remainder(difference + np.pi, 2 * np.pi) - np.pi
        np.testing.assert_allclose(apart, 0.0, rtol=0, atol=1e-9)
    for axis in "xy":
        expected = data.joint_position.sel(joint="B", axis=axis)
        np.testing.assert_allclose(table[f"B.{axis} position"], expected, rtol=0, atol=1e-9)


@pytest.mark.slow_except("0.001")
@pytest.mark.parametrize("step", [1e-2, 1e-3, 1e-4])
def test_masters_that_locate_no_events_pass_change_points(step):
    """However far off its motion is, the coupler of a parallelogram stays parallel to ground."""
    table = fmpy.simulate_fmu(
        str(written("free")), fmi_type="ModelExchange", solver="Euler", stop_time=0.3,
        step_size=step, output_interval=step, output=["a.angle", "b.angle"],
    )  # fmt: skip
    assert table["a.angle"].min() < -0.5
    np.testing.assert_allclose(table["b.angle"], 0.0, atol=1e-7)


def test_a_step_that_overlooks_a_change_point_is_an_error():
    with pytest.raises(FMICallException, match="CompletedIntegratorStep"):
        fmpy.simulate_fmu(
            str(written("free")), fmi_type="ModelExchange", solver="Euler", stop_time=0.3,
            step_size=0.15, output_interval=0.15, output=["a.angle"],
        )  # fmt: skip


class Exchange:
    """A master with classical Runge-Kutta steps, which sees events at their ends."""

    def __init__(self, unit, path, t=0.0):
        self.unit, self.t, self.until = unit, t, np.inf
        variables = unpacked(path)[0].modelVariables
        self.count = sum(v.derivative is not None for v in variables)
        self.indicated = sum(v.name.startswith("event.") for v in variables)

    def update(self):
        """Event mode."""
        found = self.unit.updateDiscreteStates()
        self.until = found[5] if found[4] else np.inf
        self.unit.enterContinuousTimeMode()
        self.signs = self.indicators()

    def indicators(self):
        """Which of them are negative."""
        values = (ctypes.c_double * self.indicated)()
        self.unit.getEventIndicators(values, self.indicated)
        return [value < 0.0 for value in values]

    def states(self):
        values = (ctypes.c_double * self.count)()
        self.unit.getContinuousStates(values, self.count)
        return np.array(values)

    def rates(self, t, y):
        slopes = (ctypes.c_double * self.count)()
        self.unit.setTime(t)
        self.unit.setContinuousStates((ctypes.c_double * self.count)(*y), self.count)
        self.unit.getContinuousStateDerivatives(slopes, self.count)
        return np.array(slopes)

    def step(self, h):
        """One step, or a shorter one to the next event; whether there was one."""
        t, end = self.t, min(self.t + h, self.until)
        h = end - t
        y = self.states()
        a = self.rates(t, y)
        b = self.rates(t + h / 2, y + h / 2 * a)
        c = self.rates(t + h / 2, y + h / 2 * b)
        d = self.rates(end, y + h * c)
        self.rates(end, y + h / 6 * (a + 2 * b + 2 * c + d))
        self.t = end
        wanted, _ = self.unit.completedIntegratorStep()
        event = wanted or end == self.until or self.indicators() != self.signs
        if event:
            self.unit.enterEventMode()
            self.update()
        return event


def test_a_state_on_the_way_across_a_change_point_is_one_of_the_unit():
    """Another instance goes on from there, bit by bit; derivatives are of functions of time."""
    path = written("free")
    names = ["a.angle", "b.angle", "c.angle"]
    with instance(path, "exchange") as one, instance(path, "exchange") as two:
        start(one, path=path)
        master = Exchange(one, path)
        master.update()
        while np.isinf(master.until):
            assert master.t < 0.2
            master.step(1e-3)
        assert master.t < CHANGES * 6 / 9 < master.until  # π/3 rad at 9 rad/s, and gravity
        master.step(1e-3)
        places = references(path)
        rates = [places["der(state.a)"], places["der(state.a.rate)"]]
        knowns = [places["state.a"], places["state.a.rate"]]
        assert list(one.getDirectionalDerivative(rates, knowns, [3.0, 2.0])) == [2.0, 0.0]
        start(two, path=path)
        restore(two, state_of(one))
        other = Exchange(two, path, master.t)
        other.until, other.signs = master.until, master.signs
        for _ in range(100):
            master.step(1e-3)
            other.step(1e-3)
            assert get(one, names, path).tolist() == get(two, names, path).tolist()
        assert master.t > CHANGES
        np.testing.assert_allclose(get(one, ["b.angle"], path), 0.0, atol=1e-9)


# --- inputs ---

ARM = """
name: Arm on a cart
gravity: [0, -9.81]
joints: {O: [0, 0]}
sliders: {cart: {joint: A, through: O, angle: 0, mass: 2}}
bars: {arm: {joints: [A, B], length: 0.4, mass: 0.5}}
springs: [{slider: cart, stiffness: 80, position: 0.1, damping: 3}]
loads: [{slider: cart, force: 1.5}]
free: {cart: {position: 0, speed: 0.2}, arm: {angle: -60 deg, speed: 1}}
simulate: {end: 1, samples: 21}
"""
SERIES = ["cart.position", "arm.angle", "arm.speed", "B.x reaction", "A.y reaction"]


def moved(law, times, what="bar: arm, torque"):
    """The same with a load in the file."""
    mechanism = linkages.loads(ARM.replace("loads: [", f"loads: [{{{what}: {law}}}, "))
    return linkages.simulate(mechanism, times=times, rtol=1e-12, outputs="all").data


@pytest.mark.parametrize(
    ("version", "name", "what"),
    [
        ("3.0", "arm.torque", "bar: arm, torque"),
        ("2.0", "cart.force", "slider: cart, force"),
        ("3.0", "loads[0]", "slider: cart, force"),
    ],
)
def test_inputs_push_as_loads_of_the_file_do(version, name, what):
    """One that is constant between communications is a sum of steps."""
    path = unit_of(ARM, version)
    assert {"arm.torque", "cart.force", "loads[0]"} == set(channel(path, "input"))
    levels, times = [0.7, -1.2, 0.4, 0.0], np.linspace(0.0, 1.0, 21)
    changes = [float(c) for c in np.diff(levels) / 2]
    law = f"{levels[0] + sum(changes)!r}" + "".join(
        f" + {c:+.3f}*sign(t - {at})".replace("+ +", "+ ").replace("+ -", "- ")
        for at, c in zip((0.25, 0.5, 0.75), changes, strict=True)
    )
    data = moved(law, times, what)
    with instance(path) as unit:
        start(unit, {name: levels[0]}, path, tolerance=1e-12)
        for k, time in enumerate(times[:-1]):
            put(unit, {name: levels[k // 5]}, path)
            unit.doStep(time, times[k + 1] - time)
            found = get(unit, ["arm.angle", "cart.position", "arm.speed"], path)
            own = data.isel(time=k + 1)
            expected = [
                own.bar_angle.sel(bar="arm"),
                own.slider_position.sel(slider="cart"),
                own.bar_speed.sel(bar="arm"),
            ]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_inputs_of_model_exchange_may_change_continuously():
    """By classical Runge-Kutta steps of 1 ms, whose error is some 1e-11, as their order says."""
    path, h = unit_of(ARM), 1e-3
    times = np.linspace(0.0, 1.0, 11)
    data = moved("2*sin(5*t)", times)
    with instance(path, "exchange") as unit:
        start(unit, path=path)
        unit.updateDiscreteStates()
        unit.enterContinuousTimeMode()
        states = (ctypes.c_double * 4)()
        slopes = (ctypes.c_double * 4)()
        unit.getContinuousStates(states, 4)
        y = np.array(states)

        def rates(t, y):
            unit.setTime(t)
            put(unit, {"arm.torque": 2 * np.sin(5 * t)}, path)
            unit.setContinuousStates((ctypes.c_double * 4)(*y), 4)
            unit.getContinuousStateDerivatives(slopes, 4)
            return np.array(slopes)

        for k in range(1000):
            t = k * h
            a = rates(t, y)
            b = rates(t + h / 2, y + h / 2 * a)
            c = rates(t + h / 2, y + h / 2 * b)
            d = rates(t + h, y + h * c)
            y = y + h / 6 * (a + 2 * b + 2 * c + d)
            if (k + 1) % 100 == 0:
                rates(t + h, y)
                own = data.isel(time=(k + 1) // 100)
                found = get(unit, ["arm.angle", "cart.position"], path)
                expected = [own.bar_angle.sel(bar="arm"), own.slider_position.sel(slider="cart")]
                np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_a_force_on_a_driven_mechanism_is_felt_by_its_drive():
    """Virtual work: the effort changes by the force times the velocity over the speed."""
    path = written("four-bar", inputs=("B.x force", "rocker.torque"))
    with instance(path) as unit:
        start(unit, path=path)
        unit.doStep(0.0, 0.1)
        before = get(unit, ["crank.effort"], path)
        put(unit, {"B.x force": 3.0, "rocker.torque": -0.5}, path)
        after = get(unit, ["crank.effort"], path)
        names = ["B.x velocity", "rocker.speed", "crank.speed"]
        velocity, turning, speed = get(unit, names, path)
    expected = -(3.0 * velocity - 0.5 * turning) / speed
    assert after - before == pytest.approx(expected, rel=1e-10)


# --- drives that accelerate ---

CRANK = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.3, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1}
  coupler: {joints: [A, B], length: 0.3, mass: 1}
  rocker: {joints: [C, B], length: 0.2, mass: 1}
  swing: {joints: [B, E], length: 0.1, mass: 0.3}
drives: {crank: {angle: 1, speed: 2}}
free: {swing: {angle: -90 deg, speed: 0}}
assembly: {B: left}
simulate: {end: 1, samples: 21}
"""
FASTER = CRANK.replace("{angle: 1, speed: 2}", "{law: 1 + 2*t + 1.5*t**2}")
ACCELERATED = ("crank.acceleration", "rocker.torque")


def assert_moves_as(table, data, limit):
    for name, expected in (
        ("crank.angle", data.bar_angle.sel(bar="crank")),
        ("swing.angle", data.bar_angle.sel(bar="swing")),
        ("rocker.speed", data.bar_speed.sel(bar="rocker")),
        ("rocker.acceleration", data.bar_acceleration.sel(bar="rocker")),
        ("crank.effort", data.drive_effort.sel(drive="crank")),
    ):
        near = limit * max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(table[name], expected, rtol=0, atol=near, err_msg=name)


@pytest.mark.slow_except("3.0-CoSimulation", "2.0-ModelExchange")
@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("version", VERSIONS)
def test_a_drive_accelerates_beyond_its_law(version, kind):
    """By 3 rad/s²: as the law of the sum; without it, as its own."""
    path, times = unit_of(CRANK, version, ACCELERATED), np.linspace(0.0, 1.0, 21)
    assert validate_fmu(str(path)) == []
    for value, text in ((3.0, FASTER), (0.0, CRANK)):
        data = linkages.simulate(linkages.loads(text), times=times, rtol=1e-12).data
        table = fmpy.simulate_fmu(
            str(path), fmi_type=kind, stop_time=1.0, output_interval=0.05, record_events=False,
            relative_tolerance=1e-12, start_values={"crank.acceleration": value},
        )  # fmt: skip
        assert_moves_as(table, data, 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "drive", "law"),
    [
        ("four-bar", "crank: {angle: 0, speed: 60 rpm}", "crank: {law: 2*pi*t + 2*t**2}"),
        ("rigid", "crank: {angle: 0, speed: 3000 rpm}", "crank: {law: 100*pi*t + 2e3*t**2}"),
    ],
)
def test_drives_without_free_coordinates_and_with_impacts_accelerate(name, drive, law):
    """Where the drive moves all of it, and where rigid contacts close: its rate does not jump.

    Impacts make 2e-8 of the round-off by which the crank is apart.
    """
    text, end = PASSING.get(name, (FOUR, 0.5))
    assert drive in text
    path, times = (
        unit_of(text, "3.0", ("crank.acceleration",)),
        np.linspace(0, end, 31),
    )
    factor = 4.0 if name == "four-bar" else 4e3
    table = fmpy.simulate_fmu(
        str(path), fmi_type="CoSimulation", stop_time=end, output_interval=end / 30,
        relative_tolerance=1e-12, start_values={"crank.acceleration": factor},
    )  # fmt: skip
    data = linkages.simulate(linkages.loads(text.replace(drive, law)), times=times, rtol=1e-12).data
    for bar in data.bar.values:
        difference = table[f"{bar}.angle"] - data.bar_angle.sel(bar=bar).values
        apart = np.remainder(difference + np.pi, 2 * np.pi) - np.pi
        np.testing.assert_allclose(apart, 0.0, rtol=0, atol=1e-7 if name == "rigid" else 1e-9)


FOUR = """
joints: {O: [0, 0], C: [0.3, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1}
  coupler: {joints: [A, B], length: 0.3, mass: 1}
  rocker: {joints: [C, B], length: 0.2, mass: 1}
drives: {crank: {angle: 0, speed: 60 rpm}}
assembly: {B: left}
"""


def test_a_drive_that_stands_still_is_led_by_its_input():
    """A sine of 0.4 rad from its second derivative, fed at every stage of steps of order 4;
    the work of the drive is the energy that the mechanism has got."""
    text = CRANK.replace("{angle: 1, speed: 2}", "{law: 1 + 2.4*t}")
    path = unit_of(text, inputs=("crank.acceleration",))
    law = CRANK.replace("{angle: 1, speed: 2}", "{law: 1 + 2.4*t + 0.4*(sin(6*t) - 6*t)}")
    data = linkages.simulate(linkages.loads(law), times=[0.0, 0.5, 1.0], rtol=1e-12).data
    names = ["crank.effort", "crank.speed", "kinetic_energy", "potential_energy"]
    with instance(path, "exchange") as unit:
        start(unit, path=path)

        class Fed(Exchange):
            def rates(self, t, y):
                put(unit, {"crank.acceleration": -14.4 * np.sin(6 * t)}, path)
                return super().rates(t, y)

        master = Fed(unit, path)
        master.update()
        seen = [get(unit, names, path)]
        for k in range(1000):
            master.step(1e-3)
            seen.append(get(unit, names, path))
            if (k + 1) % 500 == 0:
                own = data.isel(time=(k + 1) // 500)
                found = get(unit, ["crank.angle", "swing.angle", "crank.effort"], path)
                expected = [
                    own.bar_angle.sel(bar="crank"), own.bar_angle.sel(bar="swing"),
                    own.drive_effort.sel(drive="crank"),
                ]  # fmt: skip
                np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)
    effort, speed, *energies = np.transpose(seen)
    power, energy = effort * speed, sum(energies)
    work = (power[0] + power[-1] + 4 * power[1::2].sum() + 2 * power[2:-1:2].sum()) / 3000
    assert work == pytest.approx(energy[-1] - energy[0], rel=1e-8)


@pytest.mark.parametrize("kind", ["steps", "exchange"])
def test_efforts_are_linear_in_the_acceleration_of_a_drive(kind):
    """So that their directional derivatives are differences, to round-off."""
    path = unit_of(CRANK, inputs=ACCELERATED)
    places, rate = references(path), "der(state.drives.crank.deviation_rate)"
    names = ["crank.effort", "swing.acceleration", rate]
    with instance(path, kind) as unit:
        start(unit, path=path)
        before = get(unit, names, path)
        put(unit, {"crank.acceleration": 2.0}, path)
        after = get(unit, names, path)
        found = unit.getDirectionalDerivative(
            [places[n] for n in names], [places["crank.acceleration"]], [1.0]
        )
    np.testing.assert_allclose(found, (after - before) / 2.0, rtol=1e-10)
    assert found[2] == 1.0


# --- instances, states ---


def advance(unit, path, steps, step=1e-3, first=0):
    """Values of all outputs after some steps."""
    for k in range(first, first + steps):
        unit.doStep(k * step, step)
    return get(unit, channel(path, "output"), path)


@pytest.mark.parametrize("version", VERSIONS)
def test_instances_are_independent_and_reset_begins_again(version):
    """Bit by bit, with other numbers in one of them."""
    path = written("slider-crank-contact", version)
    other = {"bars.rod.length": 0.121, "drives.crank.speed": 400.0}
    with instance(path) as alone:
        start(alone, path=path)
        expected = advance(alone, path, 8, 1e-4)
        alone.terminate()
        alone.reset()
        start(alone, other, path)
        changed = advance(alone, path, 8, 1e-4)
        alone.reset()
        start(alone, path=path)
        assert advance(alone, path, 8, 1e-4).tolist() == expected.tolist()
    assert not np.allclose(expected, changed)
    with instance(path) as one, instance(path) as two:
        start(one, path=path)
        start(two, other, path)
        for k in range(8):
            found = advance(one, path, 1, 1e-4, k), advance(two, path, 1, 1e-4, k)
    assert found[0].tolist() == expected.tolist()
    assert found[1].tolist() == changed.tolist()


def state_of(unit):
    """The bytes of a state."""
    if hasattr(unit, "getFMUState"):
        return unit.serializeFMUState(unit.getFMUState())
    return unit.serializeFMUstate(unit.getFMUstate())


def restore(unit, data):
    """Put an instance into a state."""
    if hasattr(unit, "getFMUState"):
        unit.setFMUState(unit.deserializeFMUState(data))
    else:
        unit.setFMUstate(unit.deSerializeFMUstate(data))


@pytest.mark.parametrize("version", VERSIONS)
def test_a_motion_goes_on_from_a_state_in_another_instance(version):
    """Within a contact, with what it remembers of the impact, bit by bit."""
    path = written("slider-crank-contact", version)
    with instance(path) as one:
        start(one, {"bars.rod.length": 0.121}, path)
        advance(one, path, 4, 1e-4)
        data = state_of(one)
        expected = advance(one, path, 8, 1e-4, 4)
        restore(one, data)
        assert advance(one, path, 8, 1e-4, 4).tolist() == expected.tolist()
    with instance(path) as two:
        start(two, path=path)
        restore(two, data)
        assert advance(two, path, 8, 1e-4, 4).tolist() == expected.tolist()


def test_states_of_others_are_refused():
    said, path = [], written("rub")
    with instance(written("bounce")) as unit:
        start(unit, path=path)
        foreign = state_of(unit)
    with instance(path, messages=said) as unit:
        own = state_of(unit)
        for data in (foreign, own[:-1], b"x" + own[1:]):
            with pytest.raises(FMICallException):
                restore(unit, data)
        start(unit, path=path)
    with instance(path, "exchange", said) as unit, pytest.raises(FMICallException):
        restore(unit, own)
    assert len(said) == 4
    assert "values; expected" in said[1]
    assert "state of another unit" in said[2]


# --- derivatives ---

STEP = 1e-7
"""Of differences of order 4: a hundredth of the offset of a pin at which they are taken.

Forces that cancel have a round-off of 1e-12 N, which makes 1e-5 of the result."""


@pytest.mark.slow_except("3.0-double-pendulum", "3.0-rub", "2.0-five-bar-free")
@pytest.mark.parametrize("name", [*SMOOTH, *SWITCHED, "wound", "class-three", "n-four-bar"])
@pytest.mark.parametrize("version", VERSIONS)
def test_directional_derivatives_are_central_differences(version, name):
    """By states and inputs: of rates, outputs and functions of modes, also while friction holds."""
    path = written(name, version)
    states = [n for n in references(path) if n.startswith("state.")]
    knowns = [*states, *channel(path, "input")]
    unknowns = [n for n in references(path) if n.startswith(("der(", "event."))]
    unknowns += channel(path, "output")
    places = references(path)
    with instance(path, "exchange") as unit:
        start(unit, path=path)
        pushed = np.zeros(len(channel(path, "input")))
        if name == "rub":  # it rests in its friction, pushed by less
            stick(unit, path)
        ask = unit.getDirectionalDerivative

        def values(point):
            count = len(states)
            if count:
                unit.setContinuousStates((ctypes.c_double * count)(*point[:count]), count)
            put(unit, dict(zip(knowns[count:], point[count:], strict=True)), path)
            return get(unit, unknowns, path)

        point = np.concatenate([get(unit, states, path), pushed])
        if name not in ("rub", "bounce"):  # outputs have kinks where links are in line at the start
            unit.setTime(1e-4)
            point += 1e-4 * np.random.default_rng(0).normal(size=len(point))
            values(point)
        for k in range(len(knowns)):
            seed = np.random.default_rng(k).normal(size=len(knowns))
            at = [places[n] for n in unknowns], [places[n] for n in knowns]
            found = np.array(ask(*at, seed.tolist()))
            step = STEP * seed
            with np.errstate(invalid="ignore"):  # of two infinities
                wide = values(point + 2 * step) - values(point - 2 * step)
                close = values(point + step) - values(point - step)
                expected = (8 * close - wide) / (12 * STEP)
            values(point)
            kept = np.isfinite(expected)
            scale = np.abs(values(point)) + np.abs(found) + np.abs(seed).max()
            assert (np.abs(found - expected)[kept] <= 1e-4 * scale[kept]).all()


def stick(unit, path):
    """Lead the block to where its friction holds it."""
    new = hasattr(unit, "updateDiscreteStates")
    update, read = (
        (unit.updateDiscreteStates, unit.getInt32)
        if new
        else (unit.newDiscreteStates, unit.getInteger)
    )
    update()
    unit.setContinuousStates((ctypes.c_double * 2)(0.01, 0.0), 2)
    update()
    (mode,) = (v for n, v in references(path).items() if n.startswith("mode."))
    assert list(read([mode])) == [0]


def test_directional_derivatives_are_the_exact_jacobian():
    """To round-off, by each state."""
    name = "double-pendulum"
    path, rhs = written(name), linkages.compile(system(name).mechanism)
    expected = rhs.jacobian(0.0, rhs.state)
    states = [n for n in references(path) if n.startswith("state.")]
    places = references(path)
    with instance(path, "exchange") as unit:
        start(unit, path=path)
        for k, state in enumerate(states):
            found = unit.getDirectionalDerivative(
                [places[f"der({n})"] for n in states], [places[state]], [1.0]
            )
            np.testing.assert_allclose(found, expected[:, k], rtol=1e-11, atol=1e-11)


# --- what is refused ---


def refused(call, said, words):
    """A call that fails with a message."""
    del said[:]
    with pytest.raises(FMICallException):
        call()
    assert words in said[-1], said


@pytest.mark.parametrize("version", VERSIONS)
def test_wrong_calls_are_refused_with_a_message(version):
    path, said = written("four-bar", version, ("rocker.torque",)), []
    with instance(path, messages=said) as unit:
        length = "bars.crank.length"
        refused(lambda: put(unit, {length: -1.0}, path), said, "expected a finite number > 0")
        refused(lambda: put(unit, {length: np.nan}, path), said, "bars.crank.length: found nan")
        refused(lambda: put(unit, {"time": 1.0}, path), said, "cannot be set")
        refused(lambda: put(unit, {"rocker.angle": 1.0}, path), said, "cannot be set")
        refused(lambda: get(unit, ["rocker.angle"], path), said, "before initialization")
        refused(lambda: unit.doStep(0.0, 0.1), said, "a step: not allowed")
        put(unit, {length: 5.0}, path)
        refused(lambda: start(unit, path=path), said, "cannot be assembled")
        unit.reset()
        refused(lambda: start(unit, path=path, tolerance=2.0), said, "tolerance: found 2")
        unit.reset()
        start(unit, path=path)
        refused(lambda: put(unit, {length: 0.04}, path), said, "not allowed in this mode")
        refused(lambda: unit.doStep(0.5, 0.1), said, "begins at t = 0.5")
        refused(lambda: unit.doStep(0.0, -0.1), said, "expected one > 0")
        push = channel(path, "input")[0]
        refused(lambda: put(unit, {push: np.inf}, path), said, f"{push}: found inf")
        unit.doStep(0.0, 0.01)  # it goes on
        unit.terminate()
        refused(lambda: unit.doStep(0.01, 0.01), said, "after termination")


def test_units_know_their_token_and_have_no_event_mode():
    path, said = written("rub"), []
    description, folder = unpacked(path)
    own = {"unzipDirectory": folder, "modelIdentifier": description.coSimulation.modelIdentifier}
    unit = fmpy.fmi3.FMU3Slave(guid="other", **own)

    def log(_environment, _status, _category, message):
        said.append(message.decode())

    with pytest.raises(Exception, match="Failed to instantiate"):
        unit.instantiate(logMessage=log)
    assert "found the token other" in said[0]
    unit = fmpy.fmi3.FMU3Slave(guid=description.guid, **own)
    with pytest.raises(Exception, match="Failed to instantiate"):
        unit.instantiate(logMessage=log, eventModeUsed=True)
    assert "no event mode" in said[1]


def test_motions_that_end_say_why():
    path, said = unit_of(STUCK), []
    with instance(path, messages=said) as unit:
        start(unit, path=path)
        refused(lambda: unit.doStep(0.0, 1.0), said, "joint A")


STUCK = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  a: {joints: [O, A], length: 0.3, mass: 1}
  b: {joints: [A, B], length: 1, mass: 1}
  c: {joints: [C, B], length: 0.5, mass: 1}
free: {c: {angle: 90 deg, speed: 6}}
assembly: {A: [0.28, 0.1]}
"""


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"fmi": "1.0"}, "unknown version '1.0'; expected one of: 3.0, 2.0"),
        ({"inputs": ["crnk.torque"]}, "did you mean 'crank.torque'"),
        ({"inputs": ["rod.acceleration"]}, "found no input 'rod.acceleration'"),
        ({"colour": "red"}, "has no option 'colour'"),
    ],
)
def test_options_that_make_no_sense_are_refused(options, words, tmp_path):
    with pytest.raises(OptionError, match=words.replace("?", r"\?")):
        linkages.export(linkages.load("slider-crank"), "fmu", tmp_path, **options)
    assert not [*tmp_path.iterdir()]


# --- files ---


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [("COMPILERS", (), "found no C compiler"), ("OPTIONS", ("--nonsense",), "nonsense")],
)
def test_without_a_compiler_there_is_a_source_and_a_note(name, value, words, monkeypatch):
    from linkages.exports.writers import functional_mockup

    monkeypatch.setattr(functional_mockup, name, value)
    subject = Subject(linkages.load("pendulum"), "pendulum")
    ((file, content),) = files_of(subject, "fmu", {}).items()
    assert file == "pendulum.fmu"
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert sorted(archive.namelist()) == [
            "modelDescription.xml", "sources/buildDescription.xml", "sources/pendulum.c",
        ]  # fmt: skip
    assert subject.notes[0].startswith("source only")
    assert words in subject.notes[0]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Implicitly cleaning up:ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_fmpy_compiles_the_source(tmp_path):
    pytest.importorskip("cmake")
    from fmpy.build import build_platform_binary

    path = written("rub")
    folder = fmpy.extract(str(path), unzipdir=str(tmp_path / "unit"))
    shutil.rmtree(tmp_path / "unit/binaries")
    build_platform_binary(folder)
    table = fmpy.simulate_fmu(folder, stop_time=1.0, output_interval=0.1)
    own = fmpy.simulate_fmu(str(path), stop_time=1.0, output_interval=0.1)
    np.testing.assert_allclose(table["block.position"], own["block.position"], atol=1e-12)


def test_a_unit_is_its_definition_and_says_numbers_units_and_ranges():
    path = written("four-bar")
    assert linkages.load(path) == system("four-bar").mechanism
    known = {v.name: v for v in unpacked(path)[0].modelVariables}
    for number in kernel("four-bar").feed.numbers:
        variable = known[number.path]
        assert float(variable.start) == number.value
        assert variable.unit == number.unit
        assert (variable.causality, variable.variability) == ("parameter", "fixed")
    assert known["bars.crank.length"].min == "0.0"
    assert known["drives.crank.speed"].min is None
    assert known["drives.crank.speed"].displayUnit == "rpm"
    assert known["crank.effort"].unit == "N m"
    names = {quantity.name for quantity in kernel("four-bar").quantities}
    assert set(channel(path, "output")) == names


def test_numbers_of_the_file_change_the_motion_as_they_do_in_it():
    path, changed = written("four-bar"), {"bars.crank.length": 0.045, "drives.crank.angle": 0.2}
    mechanism = system("four-bar").mechanism.with_values(changed)
    data = linkages.simulate(mechanism, times=[0.0, 0.03], outputs=["bar_angle"]).data
    with instance(path) as unit:
        start(unit, changed, path)
        unit.doStep(0.0, 0.03)
        found = get(unit, ["rocker.angle"], path)
    np.testing.assert_allclose(found, data.bar_angle.sel(bar="rocker")[-1], rtol=0, atol=1e-12)


def test_motions_begin_at_zero_whenever_a_master_starts():
    """A master that begins at 0.1 s finds the unit where the motion is then."""
    path = written("double-pendulum")
    with instance(path) as one, instance(path) as two:
        start(one, path=path, tolerance=1e-12)
        one.doStep(0.0, 0.1)
        start(two, path=path, tolerance=1e-12, startTime=0.1)
        found = [get(unit, channel(path, "output"), path) for unit in (one, two)]
    assert found[0].tolist() == found[1].tolist()


STRANGE = r"""
name: 'A */ </script> "\"" \ ??/ %s "Ärm" of 5 µm'
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {"große Stange": {joints: [O, "P ü"], length: 1, mass: 1}}
free: {"große Stange": {angle: 0.3, speed: 0}}
loads: [{bar: "große Stange", torque: 1}]
"""


@pytest.mark.parametrize("version", VERSIONS)
def test_names_may_be_strange_and_repeat(version):
    path, said = unit_of(STRANGE, version), []
    assert validate_fmu(str(path)) == []
    description, _ = unpacked(path)
    assert description.modelName.startswith("A */ </script>")
    names = [v.name for v in description.modelVariables]
    assert len(names) == len(set(names))
    with instance(path, messages=said) as unit:
        refused(lambda: put(unit, {"bars.große Stange.length": -1.0}, path), said, "große Stange")
        start(unit, path=path)
        unit.doStep(0.0, 0.1)
