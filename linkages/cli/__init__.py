"""The command line; see `linkages.cli.main`."""
