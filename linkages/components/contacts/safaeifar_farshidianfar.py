"""H. Safaeifar, A. Farshidianfar, *Multibody Syst. Dyn.* (2020)."""

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return 1.25 * (1.0 - restitution) / restitution


LAW = restitution_law("safaeifar-farshidianfar", _factor)
