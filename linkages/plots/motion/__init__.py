"""Curves of a motion: over time, and of one quantity over another."""
