"""Figures of orbits, of their multipliers, and of branches."""

import json
from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import linkages
from linkages.design.ranges import ranges_of
from linkages.orbits.shooting import Change
from linkages.orbits.starting_states import section_states
from linkages.plots.chaos import orbit_figures as drawn
from linkages.plots.style import PALETTE

UNSTABLE = drawn.UNSTABLE


@pytest.fixture(scope="module")
def oscillator():
    return linkages.load("impact-oscillator")


@pytest.fixture(scope="module")
def orbit(oscillator):
    return linkages.orbit(oscillator)


def lines_of(ax, dashes):
    """Lines of branches with these dashes."""
    wanted = [line for line in ax.lines if line.get_marker() in ("", "None")]
    return [line for line in wanted if line._unscaled_dash_pattern[1] == dashes]


def test_an_orbit_has_all_figures(orbit, oscillator):
    figures = drawn.orbit_figures(orbit, oscillator)
    names = {"orbit", "orbit_multipliers", "orbit_time", "orbit_positions"}
    assert {name for name, figure in figures.items() if figure is not None} == names
    (ax,) = figures["orbit"].axes
    x, y = np.transpose(ax.lines[0].get_xydata())
    # the impact: from the stop with v to the stop with −0.8 v
    jump = int(np.argmax(np.abs(np.diff(y))))
    assert x[[jump, jump + 1]] == pytest.approx([1.0, 1.0], abs=1e-7)
    assert y[jump + 1] == pytest.approx(-0.8 * y[jump], abs=1e-7)
    assert ax.lines[1].get_xydata() == pytest.approx(orbit.section_state.to_numpy())
    panel, strip = figures["orbit_time"].axes
    assert panel.get_ylabel() == "mass.position [m]"
    assert [text.get_text() for text in strip.get_yticklabels()] == ["stops[0]\nupper"]
    assert strip.get_ylabel() == "closed"
    assert len(figures["orbit_positions"].axes) == 8


def test_contacts_are_closed_from_a_touch_to_the_next_loss():
    """From the beginning if it ends first, to the end if it does not; impacts take no time."""
    found = drawn.contact_episodes(
        [
            Change(0.1, "gap: touch", False),
            Change(0.3, "gap: touch", True),
            Change(0.4, "rub: slip", True),
            Change(0.6, "gap: touch", False),
            Change(0.7, "stop: touch", True),
            Change(0.8, "stop: touch", True),
            Change(0.9, "gap: touch", True),
        ],
        1.0,
    )
    assert found == {
        "gap": [(0.0, 0.1), (0.3, 0.6), (0.9, 1.0)],
        "stop": [(0.7, 0.7), (0.8, 0.8)],
    }


def with_multipliers(*values):
    both = [[value.real, value.imag] for value in map(complex, values)]
    return xr.Dataset(
        {
            "multiplier": (("index", "part"), both),
            "multiplier_error": ("index", np.full(len(values), 1e-12)),
        }
    )


@pytest.mark.parametrize(
    ("values", "places"),
    [
        ((-0.5, 0.2 + 0.1j, 0.2 - 0.1j), (-0.5, 0.2 + 0.1j, 0.2 - 0.1j)),
        ((-1.2, 3e-7), (-1.2, 0.0)),
        ((-1000.0, 0.5, 1e-20), (-4.0, 0.5, 0.0)),  # outside: 1 + log10
    ],
)
def test_multipliers_are_in_the_plane(values, places):
    figure = drawn.multipliers(with_multipliers(*values)).figure
    ax = figure.axes[0]
    offsets = ax.collections[0].get_offsets() @ [1.0, 1.0j]
    assert list(offsets) == pytest.approx(list(places), abs=1e-12)
    tiny = sum(abs(value) < 1e-5 for value in values)
    said = [text.get_text() for text in ax.get_legend().get_texts()]
    assert (f"{tiny} below 1e−5" in said) == (tiny > 0)
    colours = ax.collections[0].get_facecolors()
    for value, colour in zip(values, colours, strict=True):
        outside = Figure().add_subplot().plot([], color=PALETTE[abs(value) > 1])[0]
        assert colour[:3] == pytest.approx(
            [int(outside.get_color()[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        )


@pytest.fixture(scope="module")
def branches(oscillator):
    return linkages.follow(oscillator, ["parameters.A=0.3:1"], largest_step=0.2)


def test_branches_are_solid_where_they_are_stable(branches):
    """Without impacts below the grazing amplitude, unstable from there to the doubling."""
    ax = linkages.charts.branches(branches)
    special = dict(zip(branches.label.values, branches.value.to_numpy()[:, 0], strict=True))
    grazing, doubling = special["G1"], special["PD1"]
    dashed = np.concatenate([line.get_xdata() for line in lines_of(ax, UNSTABLE[1])])
    solid = [line.get_xdata() for line in lines_of(ax, None)]
    assert dashed.min() == pytest.approx(grazing, abs=1e-6)
    assert dashed.max() == pytest.approx(doubling)
    assert sorted((x.min(), x.max()) for x in solid) == [
        pytest.approx((0.3, grazing), abs=1e-6), pytest.approx((doubling, 1.0)),
    ]  # fmt: skip
    assert {text.get_text() for text in ax.texts} == {"G1", "PD1"}
    assert ax.get_ylabel() == "mass.position [m]"
    growth = ax.figure.axes[1]
    assert growth.get_yscale() == "log"
    assert growth.get_xlabel() == "parameter A"
    own = Figure().add_subplot()
    assert linkages.charts.branches(branches, "mass.velocity", own) is own
    assert own.get_ylabel() == "mass.velocity [m/s]"
    with pytest.raises(ValueError, match=r"unknown coordinate 'mass'; expected one of: mass\.pos"):
        linkages.charts.branches(branches, "mass")


@pytest.mark.slow
def test_a_branch_ends_at_the_orbit_of_half_its_period_that_it_meets():
    """Its state after half a turn was drawn there, on the other side of the bearing."""
    engine = linkages.load("idling-engine")
    data = linkages.follow(engine, ["loads[0].force=-18.7N:-18.2N"], switch=True, longest=2)
    places = section_states(engine, data)[:, :, 0]
    assert json.loads(data.attrs["branches"])[1]["ends"][-1]["reason"] == "merging"
    *_, before, last = np.flatnonzero(data.branch == 1)
    assert data.period[last] == data.period[before] / 2
    assert np.isnan(places[last, 1])
    np.testing.assert_allclose(places[before], places[last, 0], rtol=0, atol=1e-7)  # of 0.12 mm


@pytest.fixture(scope="module")
def cascade():
    crank = linkages.load("contact-slider-crank")
    vary = ["clearances.gap.size=0.12mm:0.1185mm"]
    data = linkages.follow(
        crank, vary, switch=True, unstable=False, longest=4, skip=300, largest_step=0.3
    )
    sections = (("point", "section", "coordinate"), section_states(crank, data))
    return data.assign(section_state=sections), ranges_of(crank, vary, either_way=True)


@pytest.mark.slow
def test_orbits_of_several_periods_have_all_their_section_points(cascade):
    data, ranges = cascade
    periods = [one["periods"] for one in json.loads(data.attrs["branches"])]
    assert periods == [1, 2, 4]
    counts = np.isfinite(data.section_state[:, :, 0]).sum("section").to_numpy()
    np.testing.assert_array_equal(counts, np.array(periods)[data.branch])
    # where a branch begins its points lie in pairs, at the points of the orbit that doubled
    for branch in (1, 2):
        row = int(np.flatnonzero(data.branch == branch)[0])
        count = periods[branch]
        own = data.section_state[row, :count, 0].to_numpy()
        before = json.loads(data.attrs["branches"])[branch]["parent"]
        parent = int(np.flatnonzero(data.label == before)[0])
        old = data.section_state[parent, : count // 2, 0].to_numpy()
        assert np.abs(own[:, None] - old).min(axis=1).max() < 3e-7
    figure = drawn.branch_figure(data, ranges)
    upper, lower = figure.axes
    assert lower.get_xlabel() == "radial clearance gap [mm]"
    assert upper.get_xlim() == lower.get_xlim()
    assert 0.1185 < upper.get_xlim()[0] < upper.get_xlim()[1] < 0.1201
    entries = [text.get_text() for text in upper.get_legend().get_texts()]
    assert entries == ["period 1", "period 2 from PD1", "period 4 from PD2", "stable", "unstable"]
    boxes = [text.get_window_extent() for text in upper.texts]
    assert len(boxes) == 3
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


def test_equilibria_and_cycles_are_drawn_together(tmp_path):
    """A Hopf point at μ = 0: the cycle has a period of its own, and a figure of it."""
    mechanism = linkages.loads("""
gravity: [0, 0]
parameters: {mu: -0.5}
joints: {O: [0, 0]}
sliders: {mass: {joint: P, through: O, angle: 0, mass: 1}}
loads: [{slider: mass, force: "-mass.position + mu*mass.velocity - mass.position**2*mass.velocity"}]
free: {mass: {position: 0.3, speed: 0}}
simulate: {end: 100, rtol: 1e-8}
""")
    data = linkages.follow(mechanism, ["parameters.mu=-1:0.2"], switch=True, largest_step=0.4)
    figures = drawn.branch_figures(data)
    assert list(figures) == ["follow", "follow_period"]
    upper = figures["follow_period"].axes[0]
    assert upper.get_ylabel() == "period [s]"
    heights = np.concatenate([line.get_ydata() for line in lines_of(upper, None)])
    assert np.nanmin(heights) == pytest.approx(2 * np.pi, rel=1e-3)
    entries = [text.get_text() for text in upper.get_legend().get_texts()]
    assert entries[:2] == ["equilibria", "orbits from H1"]
    for name, figure in figures.items():
        figure.savefig(tmp_path / f"{name}.png")


def test_charts_of_an_orbit(orbit):
    ax = linkages.charts.orbit(orbit)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("mass.position [m]", "mass.velocity [m/s]")
    with pytest.raises(ValueError, match=r"unknown coordinate 'arm\.angle'; expected one of: mass"):
        linkages.charts.orbit(orbit, "arm.angle")
    own = Figure().add_subplot()
    assert linkages.charts.multipliers(orbit, own) is own
