"""Systems whose motion is known, and how they are judged: the computations of docs/verdicts.md."""
