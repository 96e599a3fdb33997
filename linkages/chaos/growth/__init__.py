"""How tangents of a motion grow: exponents, indicators, and how far to believe them."""
