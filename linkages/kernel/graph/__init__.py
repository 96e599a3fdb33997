"""Scalar operations as a graph: nodes, derivatives, values with NumPy."""
