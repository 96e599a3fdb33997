"""Bodies as nodes, joints as edges: loops, mobility, and the order of solution."""
