"""A linear spring and damper, whose force jumps at the touch; usual in older work."""

from linkages.components.contributed.normal_laws import viscous_law

LAW = viscous_law("kelvin-voigt")
