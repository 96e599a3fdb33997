"""Periodic orbits and equilibria, their stability, and how they change with parameters."""
