"""R. G. Herbert, D. C. McWhannell, *J. Eng. Ind.* 99 (1977) 795."""

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return 6.0 * (1.0 - restitution) / ((2.0 * restitution - 1.0) ** 2 + 3.0)


LAW = restitution_law("herbert-mcwhannell", _factor)
