"""What goes into a kernel: parameters, time, state, laws, and where they stand."""
