"""Linkages of other programs as definitions of this one."""
