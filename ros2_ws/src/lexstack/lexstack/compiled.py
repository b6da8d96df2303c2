"""How kernels are compiled: by numba where it is there, once for each version of their source.

A kernel is a folder of that name; ``python -m lexstack.compiled`` compiles all, as the set-up does.

No ``fastmath``: sums keep their order, so runs, processes and processors agree to the bit. With
``NUMBA_DISABLE_JIT=1`` the same loops run as Python, for coverage and for reading along.

numba's cache knows one file of a function by its stamp, and none of the files that this one calls.
So what is kept lies in a folder that is named after the contents of all of them.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import sys
import tempfile
import time
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])

HERE = Path(__file__).parent
# What ``load`` has loaded. Not ``sys.modules``, where a module is while it is still being loaded,
# so that another thread could find it without its functions.
_LOADED: dict[str, Any] = {}


def available() -> bool:
    """Return whether kernels can be compiled: whether numba is installed."""
    return find_spec("numba") is not None


def compiled(function: Function) -> Function:
    """Return a function compiled for whatever types it is called with by another compiled one.

    Without numba it stays as it is: a kernel's types are imported where it is not used, too.
    """
    if not available():
        return function
    import numba  # noqa: PLC0415 - half a second, for those alone who use a kernel

    return cast("Function", numba.njit(error_model="numpy")(function))


def entry(signature: str) -> Callable[[Function], Function]:
    """Return a decorator that compiles what Python calls, or loads it as it was compiled before.

    It takes no other types than those of the signature: nothing is compiled in a tick.

    Args:
        signature: in numba's words.
    """

    def decorate(function: Function) -> Function:
        import numba  # noqa: PLC0415

        config: Any = numba.config
        before, config.CACHE_DIR = config.CACHE_DIR, str(folder())
        try:
            compile_now = numba.njit(signature, error_model="numpy", cache=True)
            return cast("Function", compile_now(function))
        finally:
            config.CACHE_DIR = before

    return decorate


def load(*names: str) -> None:
    """Load compiled modules, for whoever serves ticks: seconds or tenths of one.

    Without numba nothing is loaded.

    Args:
        names: of the modules.
    """
    if available():
        for name in names:
            _LOADED[name] = importlib.import_module(name)


def kernel(name: str) -> Any:
    """Return a compiled module that this process has loaded, else None: the plain form runs.

    Both have the same bits, so nothing but time depends on it. A process that computes little
    does without: numba costs half a second and 70 MB.

    Args:
        name: of the module.
    """
    return _LOADED.get(name)


@cache
def folder() -> Path:
    """Return where this version of all kernels is kept: beside them, else in the user's cache."""
    contents = b"".join(path.read_bytes() for path in [Path(__file__), *_sources()])
    name = f"kernels-{hashlib.sha256(contents).hexdigest()[:16]}"
    homes = (
        HERE / "__pycache__",
        Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lexstack",
    )
    for home in homes:
        if os.access(home if home.exists() else home.parent, os.W_OK):
            return home / name
    return Path(tempfile.gettempdir()) / f"lexstack-{os.getuid()}" / name


def _sources() -> list[Path]:
    return sorted(HERE.glob("**/kernel/*.py"))


def main() -> int:
    """Compile what is not compiled yet; return the exit code."""
    if not available():
        print("numba is not installed: lexstack works without kernels, more slowly")
        return 0
    # Here, as they take a tenth of a second to import, and nothing else needs them.
    from concurrent.futures import ProcessPoolExecutor  # noqa: PLC0415
    from multiprocessing import get_context  # noqa: PLC0415

    start = time.perf_counter()
    sources = _sources()
    # Each folder in one process; the one with most to compile is begun first.
    folders = {path.parent: 0 for path in sources}
    for path in sources:
        folders[path.parent] += path.stat().st_size
    order = sorted(folders, key=lambda each: -folders[each])
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        list(pool.map(_compile, [[p for p in sources if p.parent == each] for each in order]))
    print(f"the kernels are compiled ({time.perf_counter() - start:.1f} s): {folder().name}")
    return 0


def _compile(sources: list[Path]) -> None:
    """Import modules, which compiles them; in a process of its own."""
    for path in sources:
        importlib.import_module(
            ".".join(("lexstack", *path.relative_to(HERE).with_suffix("").parts))
        )


if __name__ == "__main__":
    sys.exit(main())
