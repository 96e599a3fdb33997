"""What inertia and loads do."""
