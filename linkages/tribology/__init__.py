"""Wear of joints over many revolutions, what it does to motions, and how long joints last."""
