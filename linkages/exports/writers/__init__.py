"""What export formats are written with: outlines, programs, trees of bodies."""
