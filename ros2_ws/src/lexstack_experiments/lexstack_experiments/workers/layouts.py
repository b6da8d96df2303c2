"""Names of this project's modules in this version and in earlier ones (``lexstack_core``)."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def first_of(*places: str) -> Any:
    """Return the first name that can be imported, each as ``module:name``; raises ImportError."""
    for place in places:
        module, name = place.split(":")
        try:
            return getattr(import_module(module), name)
        except (ImportError, AttributeError):
            continue
    raise ImportError(f"none of {', '.join(places)}")
