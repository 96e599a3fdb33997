"""K. H. Hunt, F. R. E. Crossley, *J. Appl. Mech.* 42 (1975) 440."""

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return 1.5 * (1.0 - restitution)


LAW = restitution_law("hunt-crossley", _factor)
