"""Definitions as validated numbers in SI; everything wrong is reported at once."""
