"""Compile the kernel, or say why not: ``python -m lexstack.hqp.kernel``."""

import sys
import time

from lexstack.hqp.kernel.compiled import available, folder


def main() -> int:
    """Compile what is not compiled yet; return the exit code."""
    if not available():
        print("numba is not installed: the hierarchy is solved by a cascade, more slowly")
        return 0
    start = time.perf_counter()
    from lexstack.hqp.kernel.exchange import solve  # noqa: F401, PLC0415 - compiles it

    print(f"the kernel is compiled ({time.perf_counter() - start:.1f} s): {folder().name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
