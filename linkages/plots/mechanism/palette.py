"""Colours by what is drawn, once for light and once for dark paper."""

from __future__ import annotations

from collections.abc import Mapping

from linkages.plots.style import BLACK, CLEARANCE, DRIVEN, FREE, GREY, LOAD, PALE, PALETTE, PASSIVE

LIGHT: Mapping[str, str] = {
    "paper": "#FFFFFF",
    "ink": BLACK,
    "pale": PALE,
    "guide": GREY,
    "bar": PASSIVE,
    "driven": DRIVEN,
    "free": FREE,
    "clearance": CLEARANCE,
    "load": LOAD,
    "cylinder": LOAD,
    "spring": PALETTE[2],
    "friction": PALETTE[8],
}
"""Role → colour."""

DARK: Mapping[str, str] = {
    "paper": "#14181C",
    "ink": "#E8E8E8",
    "pale": "#3A4148",
    "guide": "#7C858D",
    "bar": "#A9B6C0",
    "driven": "#FF8A3D",
    "free": "#5AB4F0",
    "clearance": "#FF6FB5",
    "load": "#BE94DE",
    "cylinder": "#BE94DE",
    "spring": "#3CC795",
    "friction": "#CFAE63",
}

MEANINGS: Mapping[str, str] = {
    "driven": "driven",
    "free": "free",
    "clearance": "clearance",
    "load": "load",
    "cylinder": "cylinder",
    "spring": "spring, damper",
    "friction": "friction",
}
"""Roles whose colour says something, in the words of a legend."""
