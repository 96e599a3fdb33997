"""The comparison with graphics processors works, on a stand-in for one."""

import pytest
from device import main
from stand_in_driver import installed

from linkages.kernel.code import cuda
from linkages.solvers import device_motions as accelerated


@pytest.mark.slow
def test_it_prints_a_table(monkeypatch, capsys):
    """Fewer motions than a launch takes, and more than the stand-in is filled by."""
    monkeypatch.setattr(accelerated, "FEWEST", 2)
    monkeypatch.setattr(accelerated, "PER_MULTIPROCESSOR", 4)
    monkeypatch.setattr("sys.argv", ["device.py", "--motions", "3", "9", "--end", "0.001"])
    driver = installed(monkeypatch)
    main()
    about, _, *rows = capsys.readouterr().out.splitlines()
    assert about == "Stand-in, 2 multiprocessors"
    cells = [row.split() for row in rows]
    assert [row[:4] for row in cells] == [
        ["ninebar", method, tangents, count]
        for method in ("dop853", "vern9")
        for tangents in ("0", "1")
        for count in ("3", "9")
    ]
    assert {row[-1] for row in cells} == {"equal"}
    assert all(float(number) > 0 for row in cells for number in row[4:9])
    assert not driver.contexts


def test_a_machine_without_one_says_so(monkeypatch):
    monkeypatch.setattr("sys.argv", ["device.py"])
    monkeypatch.setattr(cuda, "_LIBRARY", "libcuda_of_nobody.so.1")
    monkeypatch.setattr(cuda, "_driver", cuda._driver.__wrapped__)
    with pytest.raises(SystemExit, match="no driver of an NVIDIA graphics processor was found"):
        main()
