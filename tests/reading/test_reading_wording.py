"""How messages and tables show what was found."""

import pytest

from linkages.reading.wording import to_error


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (0.00343939, 0.0059, ("0.0034", "0.0059")),
        (-0.599123, 0.00234, ("-0.5991", "0.0023")),
        (123.456, 4.56, ("123.5", "4.6")),
        (123456.0, 789.0, ("123460", "790")),
        (-0.0001, 0.3, ("0.00", "0.30")),
        (1.18394e-11, 2e-12, ("1.18e-11", "2.0e-12")),
        (0.0, 1e-12, ("0e+00", "1.0e-12")),
        (1.5, 0.0, ("1.5", "0")),
        (1.5, float("nan"), ("1.5", "nan")),
    ],
)
def test_numbers_have_the_digits_that_their_error_tells(value, error, shown):
    assert to_error(value, error) == shown
