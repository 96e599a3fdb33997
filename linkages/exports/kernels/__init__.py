"""What other programs compute with: equations, and how they follow from a definition file."""
