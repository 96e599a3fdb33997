"""Simulating a mechanism: motion, outputs, files."""
