"""Work against error: every method, and other programs on the same equations."""
