"""What components contribute: terms, loads as measure and law, functions."""
