"""What the paper on the nine-bar shows, computed again: numbers, figures and judgements.

Shared by `parts`, which makes the page, and by `tests/reproduction`.
"""
