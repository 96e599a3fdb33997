"""Q. Zhiying, L. Qishao, *J. Dyn. Control* 4 (2006) 294."""

import math

from linkages.components.contributed.normal_laws import restitution_law


def _factor(restitution: float) -> float:
    return 0.75 * (1.0 - restitution**2) * math.exp(2.0 * (1.0 - restitution))


LAW = restitution_law("zhiying-qishao", _factor)
