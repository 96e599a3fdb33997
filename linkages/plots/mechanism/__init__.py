"""Drawings of a mechanism in one position: bodies, pairs, loads, traces, modes."""
