"""Laws of the force between journal and bearing, one file each; found by themselves."""
