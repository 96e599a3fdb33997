"""Thread-safe LRU cache."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import RLock
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


class Remembered(Generic[Key, Value]):
    """What was made for a key, made once; those that were not asked for longest are forgotten.

    Parameters
    ----------
    most
        How many are kept.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._known: OrderedDict[Key, Value] = OrderedDict()
        self._lock = RLock()

    def get(self, key: Key, make: Callable[[], Value]) -> Value:
        """What belongs to a key; made by one thread while others wait."""
        with self._lock:
            try:  # keys are large, and are hashed each time
                self._known.move_to_end(key)
            except KeyError:
                self._known[key] = make()
                if len(self._known) > self._most:
                    self._known.popitem(last=False)
            return self._known[key]

    def __len__(self) -> int:
        return len(self._known)
