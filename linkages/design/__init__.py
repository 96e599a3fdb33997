"""Which length, which mass, which tolerance: derivatives of motions, and what is decided by them."""
