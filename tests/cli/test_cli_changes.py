"""`check` says in what a mechanism differs from its file, as other commands do."""

import json


def test_check_says_what_differs(cli):
    assignments = ("--set", "bars.crank.length=41 mm", "--set", "drives.crank.speed=30 spm")
    first = cli("check", "four-bar", *assignments).out.splitlines()[0]
    assert first == "with bars.crank.length = 41 mm, drives.crank.speed = 30 spm"
    found = json.loads(cli("check", "four-bar", *assignments, "--json").out)
    assert found["changes"] == ["bars.crank.length=41 mm", "drives.crank.speed=30 spm"]


def test_check_is_silent_where_nothing_differs(cli):
    assert cli("check", "four-bar").out.splitlines()[0].startswith("Four-bar")
    assert "changes" not in json.loads(cli("check", "four-bar", "--json").out)
