"""Kernels as machine code: statements, their printing, compilation and cache."""
