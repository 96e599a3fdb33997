"""Equations of motion as graphs of scalar operations, and their compiled form."""
