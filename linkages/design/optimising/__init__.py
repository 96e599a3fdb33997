"""Which numbers make a measure least or greatest, within bounds and under constraints."""
