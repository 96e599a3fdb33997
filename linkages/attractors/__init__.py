"""Attractors of many initial states: basins, and diagrams over many starts."""
