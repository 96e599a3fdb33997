"""Equilibria of mechanisms, and how they vibrate about them."""
