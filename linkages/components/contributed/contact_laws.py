"""Laws of contact by name: normal force over indentation, with their sources."""

from __future__ import annotations

import math
from functools import cache
from typing import Annotated

from linkages.components.contributed.normal_forces import (
    ContactLaw,
    RigidContact,
    dissipative_law,
    elastic_law,
    factor_for,
    film_law,
    restitution_law,
    viscous_law,
)
from linkages.discovery import plugged
from linkages.spec.quantities import LawName

GROUP = "linkages.components.contacts"
"""Entry points of other packages that name laws of contact."""

# e is the coefficient of restitution, the value of each function the damping factor χ
BUILT_IN = (
    restitution_law(
        "carvalho-martins",
        lambda e: 1.5 * (1.0 - e) * (11.0 - e) / (1.0 + 9.0 * e),
        "A. S. Carvalho, J. M. Martins, Mech. Mach. Theory 138 (2019); for e > 1/3",
    ),
    dissipative_law(
        "hunt-crossley-constant",  # no memory of the touch: following contact has one attractor
        "K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440, with constant dissipation",
    ),
    restitution_law(
        "exact",
        factor_for,
        "J. Zhang, I. Sharf, ASME J. Appl. Mech. 76 (2009): one impact of a free body is exact",
    ),
    restitution_law(
        "flores",
        lambda e: 1.6 * (1.0 - e) / e,
        "P. Flores et al., Multibody Syst. Dyn. 25 (2011) 357",
    ),
    restitution_law(
        "gonthier",
        lambda e: (1.0 - e**2) / e,
        "Y. Gonthier et al., Multibody Syst. Dyn. 11 (2004) 209",
    ),
    restitution_law(
        "herbert-mcwhannell",
        lambda e: 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0),
        "R. G. Herbert, D. C. McWhannell, J. Eng. Ind. 99 (1977) 795",
    ),
    elastic_law("hertz", "H. Hertz, J. reine angew. Math. 92 (1881) 156: two elastic spheres"),
    restitution_law(
        "hu-guo",
        lambda e: 1.5 * (1.0 - e) / e,
        "S. Hu, X. Guo, Multibody Syst. Dyn. 35 (2015) 361",
    ),
    restitution_law(
        "hunt-crossley",
        lambda e: 1.5 * (1.0 - e),
        "K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440",
    ),
    viscous_law("kelvin-voigt", "linear spring and damper; the force jumps at the touch"),
    restitution_law(
        "lankarani-nikravesh",
        lambda e: 0.75 * (1.0 - e**2),
        "H. M. Lankarani, P. E. Nikravesh, J. Mech. Des. 112 (1990) 369",
    ),
    restitution_law(
        "lee-wang",
        lambda e: 0.75 * (1.0 - e),
        "T. W. Lee, A. C. Wang, J. Mech. Transm. Autom. Des. 105 (1983) 534",
    ),
    film_law(
        "lubricated",
        "short journal bearing, ruptured where the film would pull (Gümbel, Ocvirk)",
        whole=False,
    ),
    film_law(
        "lubricated-full",
        "short journal bearing with a film that bears tension, as under high pressure",
        whole=True,
    ),
    ContactLaw(
        "restitution",
        ("restitution",),
        lambda numbers: RigidContact(numbers["restitution"], numbers["least_rate"]),
        ("least_rate",),
        rigid=True,
        source="rigid bodies: Newton's impact law, and a constraint while contact lasts",
    ),
    restitution_law(
        "safaeifar-farshidianfar",
        lambda e: 1.25 * (1.0 - e) / e,
        "H. Safaeifar, A. Farshidianfar, Multibody Syst. Dyn. (2020)",
    ),
    restitution_law(
        "zhiying-qishao",
        lambda e: 0.75 * (1.0 - e**2) * math.exp(2.0 * (1.0 - e)),
        "Q. Zhiying, L. Qishao, J. Dyn. Control 4 (2006) 294",
    ),
)


@cache
def contact_laws() -> dict[str, ContactLaw]:
    """All laws by their names, those of other packages last."""
    return {law.name: law for law in (*BUILT_IN, *(law for _, law in plugged(GROUP)))}


ContactName = Annotated[str, LawName(contact_laws, "a law of contact")]
