"""``python -m linkages``."""

from linkages.cli.main import main

if __name__ == "__main__":
    main()
