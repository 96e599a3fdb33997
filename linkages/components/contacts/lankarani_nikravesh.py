"""H. M. Lankarani, P. E. Nikravesh, *J. Mech. Des.* 112 (1990) 369."""

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return 0.75 * (1.0 - restitution**2)


LAW = restitution_law("lankarani-nikravesh", _factor)
