"""Whether a motion is regular or chaotic, and the evidence for it."""
