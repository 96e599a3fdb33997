"""A. S. Carvalho, J. M. Martins, *Mech. Mach. Theory* 138 (2019); made for more than 1/3."""

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return 1.5 * (1.0 - restitution) * (11.0 - restitution) / (1.0 + 9.0 * restitution)


LAW = restitution_law("carvalho-martins", _factor)
