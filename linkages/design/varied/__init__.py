"""What is varied, within which bounds, and a definition with the numbers that were found."""
