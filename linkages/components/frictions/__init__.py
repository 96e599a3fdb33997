"""Laws of friction of slip under a normal force, one file each; found by themselves."""
