"""What the paper on the nine-bar shows, computed again: numbers, figures and judgements.

Shared by `docs/figures_paper.py`, which makes the page, and by `tests/reproduction`.
"""
