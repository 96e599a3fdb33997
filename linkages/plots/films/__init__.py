"""Films of a motion: scenes, frames, and the files that they are written to."""
