"""Definition files of random mechanisms are read as their terms say, written down another way."""

from collections import Counter

import jsonschema
import numpy as np
import pytest
import yaml
from absolute_coordinates import AbsoluteModel
from absolute_outputs import outputs
from kernel_values import disagreements
from numpy.random import default_rng
from random_mechanisms import seeded
from spoiled_definitions import spoiled

from linkages.components.mechanisms.definition import from_document
from linkages.components.mechanisms.registry import definition_schema
from linkages.errors import InputError
from linkages.reading.document import parse


@pytest.mark.slow_except("?", "1?")
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


@pytest.mark.slow
def test_the_schema_refuses_nothing_that_is_read():
    """Random files with everything in them, then with one thing changed, right or wrong.

    The other way round cannot hold: a schema sees one entry at a time.
    """
    validator, generator = jsonschema.Draft7Validator(definition_schema()), default_rng(0)
    counts = Counter[tuple[bool, bool]]()
    for seed in range(30):
        definition = yaml.safe_load(seeded(seed).text)
        for content in (definition, *(spoiled(definition, generator) for _ in range(15))):
            read, valid = _is_read(content), validator.is_valid(content)
            assert valid or not read, content
            counts[read, valid] += 1
    # it has been tried: right files, files that both refuse, and files that only `check` refuses
    assert min(counts[case] for case in ((True, True), (False, False), (False, True))) > 30
    assert counts[False, False] > counts[False, True]


def _is_read(content):
    try:
        from_document(parse(yaml.safe_dump(content, allow_unicode=True), "m.yaml"))
    except InputError:
        return False
    return True
