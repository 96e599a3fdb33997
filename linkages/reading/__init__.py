"""Definition files to plain mappings in which everything knows its place in the text."""
