"""What is looked at within a step: samples, margins, crossings, turns, tangents."""
