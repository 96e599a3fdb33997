"""Options of a run: stated once, for the definition file, keyword arguments, flags and results."""
