"""K. H. Hunt, F. R. E. Crossley, *J. Appl. Mech.* 42 (1975) 440, with constant dissipation.

It needs no memory of how a contact began, so that following contact has one attractor.
"""

from linkages.components.contributed.normal_laws import dissipative_law

LAW = dissipative_law("hunt-crossley-constant")
