"""Which length, which mass, which tolerance: derivatives of motions, and decisions by them."""
