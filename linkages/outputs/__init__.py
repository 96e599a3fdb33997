"""Outputs that stand in files of their own: found by themselves."""
