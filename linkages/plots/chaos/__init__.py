"""Figures of sections, exponents, diagrams and maps."""
