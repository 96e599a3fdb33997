"""What compiled loops are made of: memory, stages, whole turns."""
