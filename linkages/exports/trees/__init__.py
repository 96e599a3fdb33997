"""Linkages as trees of bodies with loops that constraints close: what simulators of bodies take."""
