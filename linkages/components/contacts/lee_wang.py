"""T. W. Lee, A. C. Wang, *J. Mech. Transm. Autom. Des.* 105 (1983) 534."""

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return 0.75 * (1.0 - restitution)


LAW = restitution_law("lee-wang", _factor)
