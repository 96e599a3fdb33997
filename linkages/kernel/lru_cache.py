"""Thread-safe LRU cache."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import RLock
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


class LRUCache(Generic[Key, Value]):
    """At most `size` values by key, each made once; the least recently used ones are dropped."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._known: OrderedDict[Key, Value] = OrderedDict()
        self._lock = RLock()

    def get(self, key: Key, make: Callable[[], Value]) -> Value:
        """The value of a key; one thread makes it while others wait."""
        with self._lock:
            try:  # keys are large, and are hashed each time
                self._known.move_to_end(key)
            except KeyError:
                self._known[key] = make()
                if len(self._known) > self._size:
                    self._known.popitem(last=False)
            return self._known[key]

    def __len__(self) -> int:
        return len(self._known)
