"""What can be said of a series of numbers or points, whatever it comes from."""
