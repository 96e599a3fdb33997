"""The damping with which one impact of a free body reaches the wanted restitution exactly.

The equation is that of J. Zhang, I. Sharf, *ASME J. Appl. Mech.* 76 (2009), who solve the same one.
"""

from linkages.components.contributed.normal_laws import restitution_law
from linkages.components.contributed.restitutions import factor_for

LAW = restitution_law("exact", factor_for)
