import pytest

from linkages.components.contributed.load_measures import GROUND, Revolute, revolute_pairs


@pytest.mark.parametrize("count", [1, 2, 3, 6])
def test_a_pin_of_k_bodies_is_k_minus_1_pairs(count):
    bodies = tuple(f"bar{i}" for i in range(count))
    pairs = revolute_pairs("A", bodies)
    assert len(pairs) == count - 1
    assert all(pair.joint == "A" and pair.first == "bar0" for pair in pairs)
    assert tuple(pair.second for pair in pairs) == bodies[1:]


def test_the_ground_comes_first():
    (pair,) = revolute_pairs("O", (GROUND, "crank"))
    assert pair == Revolute(joint="O", first="ground", second="crank")


def test_frozen_and_keyword_only():
    pair = Revolute(joint="O", first="a", second="b")
    with pytest.raises(AttributeError):
        pair.joint = "P"
    with pytest.raises(TypeError):
        Revolute("O", "a", "b")
