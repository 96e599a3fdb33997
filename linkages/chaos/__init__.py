"""Whether a motion is regular or chaotic: sections, exponents, diagrams, maps, verdicts."""
