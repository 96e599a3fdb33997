from group_models import TRIAD
from linkage_models import program, system, system_of, text_of

from linkages.kernel.code.program import PARTS, report_kernel
from linkages.kernel.differentiation import SEVERAL
from linkages.operations import ELEMENTARY, KINDS


def report(of):
    return report_kernel(of.model, program(of))


def test_the_nine_bar_does_not_depend_on_the_inertia_of_its_cranks():
    """Driven bodies have no equation of motion: their inertia enters the torques alone."""
    left_out = report(system("ninebar")).left_out
    assert left_out == (
        ("bars", "crank1", "mass"),
        ("bars", "crank1", "inertia"),
        ("bars", "crank4", "mass"),
        ("bars", "crank4", "inertia"),
    )


def test_a_motion_without_free_coordinates_needs_no_inertia_at_all():
    left_out = report(system("slidercrank")).left_out
    assert left_out == (
        ("bars", "crank", "mass"),
        ("bars", "crank", "inertia"),
        ("bars", "rod", "mass"),
        ("bars", "rod", "inertia"),
        ("sliders", "piston", "mass"),
        ("loads", 0, "force"),
    )


def test_a_free_mechanism_needs_everything():
    assert report(system("clearance")).left_out == ()
    assert report(system("doublependulum")).left_out == ()


def test_what_is_absent_is_not_left_out():
    massless = text_of("ninebar").replace("mass: 0.985, inertia: 8.390e-3", "mass: 0, inertia: 0")
    left_out = report(system_of(massless)).left_out
    assert left_out == (("bars", "crank4", "mass"), ("bars", "crank4", "inertia"))


def test_counts_of_the_pendulum():
    """The place of its end needs a cosine and a sine; there is no loop to solve."""
    counts = report(system("pendulum")).counts
    state = counts["once per state"]
    assert set(counts) == set(PARTS)
    assert set(state) == set(KINDS)
    assert (state["trigonometric calls"], state["divisions"]) == (2, 1)
    assert state["square roots"] == 0
    assert sum(counts["once per distinct time"].values()) == 0


def test_one_square_root_for_each_block_of_the_nine_bar():
    counts = report(system("ninebar")).counts
    roots = [counts[part]["square roots"] for part in PARTS]
    assert sum(roots) - counts["once per run"]["square roots"] == 3
    trigonometric = [counts[part]["trigonometric calls"] for part in PARTS]
    assert trigonometric == [0, 4, 2]


def test_counts_are_those_of_the_program():
    of = system("ninebar")
    written = program(of)
    counts = report_kernel(of.model, written).counts
    operations = ELEMENTARY.keys() | SEVERAL.keys()
    for part, level in PARTS.items():
        assert sum(counts[part].values()) == sum(
            node.operation in operations for node in written.groups[level]
        )
        assert len(written.groups[level]) == sum(counts[part].values())


DRIVEN = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1}}
springs: [{bar: rod, stiffness: 2, angle: 0.1}]
loads: [{bar: rod, torque: '3*sin(2*t)'}, {joint: P, force: [5, 'exp(-t)']}]
masses: {P: 0.5}
KNOWN: {rod: {angle: 0.3, speed: 1}}
"""


def test_numbers_of_all_loads_are_listed():
    """Also those of formulas, and of masses at joints."""
    left_out = report(system_of(DRIVEN.replace("KNOWN", "drives"))).left_out
    expected = {
        ("bars", "rod", "mass"),
        ("bars", "rod", "inertia"),
        ("masses", "P"),
        ("springs", 0, "stiffness"),
        ("springs", 0, "angle"),
        ("loads", 0, "torque", 0),
        ("loads", 0, "torque", 1),
        ("loads", 1, "force", 0),
    }
    assert {*left_out} == expected
    assert report(system_of(DRIVEN.replace("KNOWN", "free"))).left_out == ()


def test_every_operation_is_of_some_kind_and_every_kind_has_one():
    assert {row.kind for row in (*ELEMENTARY.values(), *SEVERAL.values())} == {*KINDS}


def test_counts_of_a_group_that_is_iterated():
    counts = report(system_of(TRIAD)).counts["once per state"]
    assert counts["iterations"] == 1
    assert counts["linear systems"] >= 2
