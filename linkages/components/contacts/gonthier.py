"""Y. Gonthier et al., *Multibody Syst. Dyn.* 11 (2004) 209."""

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return (1.0 - restitution**2) / restitution


LAW = restitution_law("gonthier", _factor)
