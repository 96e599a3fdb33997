"""Points at which a motion is looked at: once per period, or where something has a value."""
