"""What is said about a definition or a motion: assumptions, doubts, stops."""
