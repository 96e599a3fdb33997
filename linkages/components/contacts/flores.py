"""P. Flores et al., *Multibody Syst. Dyn.* 25 (2011) 357."""

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return 1.6 * (1.0 - restitution) / restitution


LAW = restitution_law("flores", _factor)
