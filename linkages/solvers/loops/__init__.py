"""The compiled loops over steps: adaptive, fixed, implicit."""
