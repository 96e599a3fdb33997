"""The commands, one file for each, and the reports that they alone print."""
