"""What other programs compute with: the equations of a mechanism, and how they follow from a file."""
