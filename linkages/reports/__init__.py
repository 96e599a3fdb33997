"""What people take along of a run: tables in their units, and a page."""
