"""Mechanisms: read from definitions, checked as a whole, written again."""
