"""Definition files of random mechanisms are read as their terms say, written down another way."""

import numpy as np
import pytest
from absolute_coordinates import AbsoluteModel
from absolute_outputs import outputs
from kernel_values import disagreements
from random_mechanisms import seeded

from linkages.components.definition import from_document
from linkages.reading.document import parse


@pytest.mark.parametrize("seed", range(60))
def test_a_file_means_what_its_terms_say(seed):
    grown = seeded(seed)
    read, built = from_document(parse(grown.text, "m.yaml")), grown.mechanism
    first, second = (
        outputs(model, model.solve(grown.start(model)))
        for model in (AbsoluteModel(read), AbsoluteModel(built))
    )
    assert set(first) == set(second)
    assert {name: list(values) for name, values in first.items()} == {
        name: list(values) for name, values in second.items()
    }
    # the same numbers in the same order, but for what `1 - ratio` and the like round
    assert not disagreements(first, second, 1e-12)
    hints = {joint: hint.position for joint, hint in read.hints.items()}
    assert hints.keys() == built.hints.keys()
    for joint, place in hints.items():
        assert np.hypot(*(np.array(place) - built.hints[joint].position)) < 1e-15
