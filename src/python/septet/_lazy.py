"""Objects whose arrays are made at the first access."""

from __future__ import annotations

from typing import Any, Callable, Dict


class Lazy:
    """An immutable object with a cache of arrays. Threads may share it."""

    __slots__ = ("_cache", "__weakref__")
    _cache: Dict[str, Any]

    def _made(self, name: str, make: Callable[[], Any]) -> Any:
        """Returns a value of the cache. If two threads make it at the same time, both get the same one."""
        try:
            return self._cache[name]
        except KeyError:
            return self._cache.setdefault(name, make())

    def _begin(self) -> None:
        """Starts an object with an empty cache. An object is made once."""
        if hasattr(self, "_cache"):
            raise AttributeError(f"a septet.{type(self).__name__} cannot be changed: make a new one")
        self._set("_cache", {})

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a septet.{type(self).__name__} cannot be changed: {name}")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a septet.{type(self).__name__} cannot be changed: {name}")
