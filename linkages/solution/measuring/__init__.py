"""Numbers out of motions: what measures say, located between the samples."""
