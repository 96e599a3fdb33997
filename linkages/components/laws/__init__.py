"""Laws: what drives prescribe and loads follow."""
