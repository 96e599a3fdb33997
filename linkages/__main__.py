"""``python -m linkages``, and the program `linkages`."""

from __future__ import annotations


def main() -> None:
    """Run the command line as a process of its own.

    What it imports takes a while, so signals are looked after before.
    """
    from linkages import interrupts

    interrupts.end_at_once()
    from linkages.cli.main import main as run

    try:
        run()
    except SystemExit as end:
        if interrupts.received():
            _leave(end)
        raise


def _leave(end: SystemExit) -> None:
    """End without waiting for threads that still compute; everything is written."""
    import os
    import sys

    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(end.code if isinstance(end.code, int) else 1)


if __name__ == "__main__":
    main()
