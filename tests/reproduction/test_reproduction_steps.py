"""RK4, the paper's method, at several steps."""

import pytest
from make.reproduction import steps
from make.reproduction.reported import STARTS


@pytest.fixture(scope="module", params=STARTS)
def study(request):
    return request.param, steps.study(request.param)


def test_converged_answer_does_not_depend_on_the_method():
    """Otherwise ten digits could not be counted."""
    for start in STARTS:
        assert steps.converged(start)[1] < 1e-9


@pytest.mark.slow_except("librating")
def test_digits_go_wrong_at_the_steps_of_the_page(page, study):
    start, found = study
    kept = [steps.StepError(*row) for row in page["steps"]["studies"][start]]
    for digit in (1, 3):
        assert steps.first_wrong(found, digit) == steps.first_wrong(kept, digit)


@pytest.mark.slow_except("librating")
def test_error_falls_with_the_order_of_the_method_or_faster(study):
    """At least fourth order, where neither round-off nor saturation hides it."""
    _, found = study
    kept = [row for row in found if 1e-8 < row.error < 3e-2]
    ratio = kept[-1].step / kept[0].step
    assert kept[-1].error / kept[0].error > ratio**4 / 2


@pytest.mark.parametrize(("error", "digits"), [(0.051, 0), (0.049, 1), (4.9e-4, 3), (1e-20, 15)])
def test_digits_are_counted_as_for_the_horizon(error, digits):
    assert steps.StepError(1e-3, error).digits == digits
