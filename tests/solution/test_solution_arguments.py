"""Arguments of `simulate` that make no sense are named, and no line of a file is blamed."""

import numpy as np
import pytest

import linkages
from linkages.errors import InputError


@pytest.fixture(scope="module")
def pendulum():
    return linkages.load("pendulum", set={"simulate.end": 0.1})


@pytest.mark.parametrize(
    ("arguments", "kind", "words"),
    [
        ({"method": "RK45"}, ValueError, r"unknown method 'RK45'; expected one of: dop853"),
        ({"method": "rk4"}, ValueError, r"method 'rk4' needs a step"),
        ({"method": "rk4", "step": 1e-12}, ValueError, r"step 1e-12 s needs more than 100000000"),
        ({"samples": 11.5}, ValueError, r"samples must be a whole number > 0, found 11\.5"),
        ({"samples": "11"}, TypeError, r"samples must be a number, found '11'"),
        ({"samples": True}, TypeError, r"samples must be a number, found True"),
        ({"samples": float("inf")}, ValueError, r"samples must be a whole number > 0, found inf"),
        ({"samples": 1}, ValueError, r"samples must be at least 2"),
        ({"rtol": "1e-3"}, TypeError, r"rtol must be a number, found '1e-3'"),
        ({"rtol": 2}, ValueError, r"rtol must be from 1e-14 to 1, found 2"),
        ({"atol": None, "end": "1"}, TypeError, r"end must be a number, found '1'"),
        ({"step": "x"}, TypeError, r"step must be a number, found 'x'"),
        ({"max_steps": 100.5}, ValueError, r"max_steps must be a whole number > 0, found 100\.5"),
        ({"max_steps": 10**20}, ValueError, r"max_steps must be a whole number > 0, at most 9007"),
    ],
    ids=str,
)
def test_an_argument_is_named(pendulum, arguments, kind, words):
    with pytest.raises(kind, match=words) as caught:
        linkages.simulate(pendulum, **arguments)
    assert not isinstance(caught.value, InputError)


def test_more_steps_than_can_be_counted():
    with pytest.raises(
        InputError, match=r"simulate\.max_steps: expected a whole number > 0, at most"
    ):
        linkages.load("pendulum", set={"simulate.max_steps": 1e30})


def test_what_the_file_says_is_an_error_of_the_file():
    """Even where an argument equals a default."""
    with pytest.raises(InputError, match=r"simulate\.method: unknown method 'RK45'"):
        linkages.simulate(linkages.load("pendulum", set={"simulate.method": "RK45"}))


@pytest.mark.parametrize("samples", [11, 11.0, np.int64(11), np.float32(11)])
def test_whole_numbers_of_any_type(pendulum, samples):
    assert linkages.simulate(pendulum, samples=samples).data.sizes["time"] == 11


@pytest.mark.parametrize("name", ["periods", "skip"])
def test_exponents_name_their_arguments_too(name):
    with pytest.raises(ValueError, match=rf"{name} must be a whole number >=? 0, found 20\.5"):
        linkages.lyapunov(linkages.load("pendulum"), **{name: 20.5})


def test_exponents_take_whole_numbers_of_any_type(pendulum):
    found = linkages.lyapunov(pendulum, periods=20.0, skip=np.int64(1), count=1)
    expected = linkages.lyapunov(pendulum, periods=20, skip=1, count=1)
    assert found.exponent.to_numpy().tolist() == expected.exponent.to_numpy().tolist()
