"""Internal states: currents, deflections, integrals, pressures, and their rates."""

from __future__ import annotations

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable


def _units(model: Model) -> list[str]:
    return [state.unit for state in model.mechanism.internal.values()]


OUTPUTS = {
    "internal_state": Variable(
        ("internal",), "", "internal state", lambda model: model.internal,
        default=True, unit_of=_units, rate="internal_state_rate",
    ),
    "internal_state_rate": Variable(
        ("internal",), "", "rate of an internal state",
        lambda model: model.changes[len(model.topology.free) :],
        unit_of=lambda model: [f"{unit or '1'}/s" for unit in _units(model)], smooth=False,
    ),
}  # fmt: skip
