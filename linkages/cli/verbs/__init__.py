"""What commands compute and report, a file for those of a kind."""
