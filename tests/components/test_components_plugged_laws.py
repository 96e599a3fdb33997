"""A law of another package, installed beside this one."""

import subprocess
import sys

MODULE = '''
from typing import Generic

from linkages.components.contributed.component import component
from linkages.components.laws import TIME, NamedLaw, Value, argument


@component
class Growth(Generic[Value]):
    """In proportion to time.

    Parameters
    ----------
    per_second
        In the units of what the law gives, per second.
    """

    per_second: Value


@component
class GrowthLaw(NamedLaw, Generic[Value]):
    """A law that grows steadily; see `Growth`."""

    growth: Growth[Value]

    def function(self, path):
        return argument((*path, "growth"), "per_second", float(self.growth.per_second)) * TIME
'''
USE = '''
import linkages
mechanism = linkages.loads("""
joints: {O: [0, 0]}
bars: {arm: {joints: [O, A], length: 1, mass: 3}}
free: {arm: {angle: 0, speed: 0}}
loads: [{bar: arm, torque: {growth: {per_second: 6 N*m}}}]
""")
angle = linkages.simulate(mechanism, end=2.0, samples=3).data.bar_angle.to_numpy()[-1, 0]
assert abs(angle - 8.0) < 1e-8, angle  # J = 1 kg m², M = 6t: θ = t³
assert linkages.loads(mechanism.to_yaml()) == mechanism
'''


def test_a_law_of_an_entry_point_is_read_and_integrated(tmp_path):
    (tmp_path / "growing.py").write_text(MODULE, encoding="utf-8")
    about = tmp_path / "growing-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: growing\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[linkages.laws]\ngrowth = growing:GrowthLaw\n")
    script = f"import sys; sys.path.append({str(tmp_path)!r})\n{USE}"
    run = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", "-c", script],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
