"""The same question asked of many mechanisms: points, chunks, stores, cores."""
