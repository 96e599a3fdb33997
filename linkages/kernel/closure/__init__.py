"""Where everything is and how it moves: positions and rates, block by block."""
