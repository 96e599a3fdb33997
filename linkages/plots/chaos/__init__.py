"""Figures of sections, exponents, diagrams and maps, and the page of a verdict."""
