"""One page that shows a motion: offline, in a single file."""
