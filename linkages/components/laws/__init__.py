"""Laws of time: what drives prescribe and loads follow."""
