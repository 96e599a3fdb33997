"""What is read off a motion: reactions, series, surfaces, peaks."""
