"""The loops over steps, which write themselves: adaptive, fixed, implicit."""
