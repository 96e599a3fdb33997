"""S. Hu, X. Guo, *Multibody Syst. Dyn.* 35 (2015) 361."""

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return 1.5 * (1.0 - restitution) / restitution


LAW = restitution_law("hu-guo", _factor)
