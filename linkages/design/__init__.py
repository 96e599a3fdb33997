"""Which length, which mass, which tolerance: derivatives, and what is decided by them."""
