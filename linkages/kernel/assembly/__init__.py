"""How a mechanism is put together where it starts: modes, free coordinates, redundancy."""
