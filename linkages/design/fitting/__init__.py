"""Which numbers make the motion go as it was measured, and how well they are known."""
