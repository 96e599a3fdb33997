"""How a linkage moves: one march, its guards and transitions; driven motions."""
