"""Random mechanisms: angles at common times are the same, however few the samples are."""

import pytest
from random_mechanisms import seeded

import linkages

MANY = 1001
CLOSE = 1e-5
"""Dense output of the same steps; a turn more or less is 6.3."""


def check_samples(seed):
    """All bars, forward and backward in time, as far as the motion goes."""
    found = seeded(seed, most=4).mechanism
    for end in (1.0, -1.0):
        how = {"end": end, "rtol": 1e-9, "outputs": ["bar_angle"], "max_steps": 20_000}
        many = linkages.simulate(found, samples=MANY, throw=False, **how).data.bar_angle.to_numpy()
        for samples in (2, 3, 6, 11, 101):
            few = linkages.simulate(found, samples=samples, throw=False, **how).data.bar_angle
            wanted = many[:: (MANY - 1) // (samples - 1)]
            assert len(few) == len(wanted)
            assert few.to_numpy() == pytest.approx(wanted, abs=CLOSE), (samples, end)


@pytest.mark.slow_except("0")
@pytest.mark.parametrize("seed", range(3))
def test_angles_do_not_depend_on_samples(seed):
    check_samples(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3, 25))
def test_angles_of_many_mechanisms_do_not_depend_on_samples(seed):
    check_samples(seed)
