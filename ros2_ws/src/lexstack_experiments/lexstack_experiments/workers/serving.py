"""How a worker hears and answers: a line of JSON each way, on standard input and output.

Whatever libraries print goes to standard error, so it cannot come between the lines.
"""

from __future__ import annotations

import gc
import json
import os
import sys
from collections.abc import Callable, Mapping
from typing import Any


def serve(handlers: Mapping[str, Callable[..., Any]]) -> None:
    """Answer requests until standard input ends.

    A request is an object whose ``do`` names the handler; its other entries are the arguments. The
    answer is ``{"answer": ...}``, or ``{"error": ...}`` with the exception in one line.

    Args:
        handlers: by name; they return what JSON can hold.
    """
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = {"answer": handlers[request.pop("do")](**request)}
        except Exception as error:  # noqa: BLE001 - told to the parent, who raises
            answer = {"error": f"{type(error).__name__}: {error}".splitlines()[0]}
        out.write(json.dumps(answer) + "\n")
        out.flush()


def uncollected(work: Callable[[], Any]) -> Any:
    """Return what ``work`` returns, with garbage collection off meanwhile."""
    gc.collect()
    gc.disable()
    try:
        return work()
    finally:
        gc.enable()
