"""Places in integrated vectors, against vectors whose entries say what they are."""

from itertools import product

import numpy as np
import pytest

from linkages.kernel.layout import Layout

CASES = [
    pytest.param(
        Layout(("a", "b"), internal, carried, (), work, losses, tangents),
        id=f"{internal}-{carried}-{work}-{losses}-{tangents}",
    )
    for internal, carried, work, losses, tangents in product(
        [(), ("z",)], [(), ("c",), ("c", "d")], [False, True], [0, 2], [0, 1, 4]
    )
]


def named(layout):
    """The entries of an integrated vector as the docstring of `Layout` lists them."""
    moved = [*layout.free, *layout.internal]
    tangents = [f"{k}:{name}" for k in range(layout.tangents) for name in moved]
    done = [*(["work"] if layout.work else []), *(f"loss {k}" for k in range(layout.losses))]
    half = [*moved, *layout.carried, *done, *tangents]
    return np.array([(name, 0) for name in half] + [(name, 1) for name in half], dtype=object)


def entries(vector):
    return [tuple(entry) for entry in vector]


@pytest.mark.parametrize("layout", CASES)
def test_parts_of_a_vector_are_what_they_are_called(layout):
    vector = named(layout)
    assert len(vector) == 2 * layout.size
    own = [(name, half) for half in (0, 1) for name in layout.coordinates]
    assert entries(vector[layout.motion_rows]) == own
    # a state has coordinates and rates of bodies, then internal states: rates of their integrals
    bodies = [(name, half) for half in (0, 1) for name in layout.bodies]
    internal = [(name, 1) for name in layout.internal]
    assert entries(vector[layout.motion_rows][layout.state_rows]) == bodies + internal
    assert entries(vector[layout.internal_rows]) == internal
    free = [(name, half) for half in (0, 1) for name in layout.free]
    for column, places in enumerate(layout.tangent_rows.T):
        tangent = [(f"{column}:{name}", half) for name, half in free + internal]
        assert entries(vector[places]) == tangent
    columns = [f"{k}:{name}" for k in range(layout.tangents) for name in layout.internal]
    idle = [(name, 0) for name in (*layout.internal, *columns)]
    assert entries(vector[layout.idle_rows]) == idle
    carried = [(name, half) for half in (0, 1) for name in layout.carried]
    assert entries(vector[layout.motion_rows][layout.carried_rows]) == carried
    assert entries(layout.lost(vector)) == [(f"loss {k}", 1) for k in range(layout.losses)]
    if layout.work:
        assert tuple(vector[layout.work_row]) == ("work", 1)
    else:
        assert layout.work_done(np.zeros(2 * layout.size)) is None


@pytest.mark.parametrize("layout", CASES)
def test_what_is_packed_comes_out_again(layout):
    random = np.random.default_rng(3)
    state = random.normal(size=2 * len(layout.bodies) + len(layout.internal))
    motion = layout.moving(state)
    assert (motion[layout.state_rows] == state).all()
    tangents = random.normal(size=(layout.directions, layout.tangents))
    done = [2.5] * layout.work + [0.5, 0.25][: layout.losses]
    vector = layout.packed(motion, done, tangents)
    assert layout.lost(vector).tolist() == [0.5, 0.25][: layout.losses]
    assert (layout.motion(vector) == motion).all()
    assert (vector[layout.tangent_rows] == tangents).all()
    assert not layout.work or layout.work_done(vector) == 2.5
    columns = layout.motion(np.stack([vector, 2 * vector], axis=1))
    assert (columns == np.stack([motion, 2 * motion], axis=1)).all()
