"""Which tolerance matters: contributions, worst case, root of the sum of squares, Monte Carlo."""
