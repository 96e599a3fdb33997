"""Laws of the force that presses a pin against its hole, one file each; found by themselves."""
