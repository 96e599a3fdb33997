"""Coefficients of methods, and the order conditions that they must meet."""
