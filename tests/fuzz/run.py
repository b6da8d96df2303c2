"""Feeds random inputs to configuration and message conversion, and says how many were tried.

With atheris the coverage guides the inputs; without it they are mutations of good ones.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import numpy as np

WORDS = (b"\x00", b"\xff" * 4, b".nan", b".inf", b"-1", b"1e999", b"&a [*a]", b"\t", b"? ", b"!!x ")
MODULES = {"config": "support.fuzz_config", "messages": "support.fuzz_messages"}


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """Return an input with a few of its bytes replaced, removed, doubled or put in."""
    result = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        at, length = (int(v) for v in rng.integers(0, (len(result) + 1, 17)))
        kind = int(rng.integers(6))
        if kind == 0:
            result[at : at + length] = rng.bytes(length)
        elif kind == 1:
            del result[at : at + length]
        elif kind == 2:
            result[at:at] = result[at : at + 8 * length]
        elif kind == 3:
            result[at:at] = WORDS[int(rng.integers(len(WORDS)))]
        elif kind == 4:
            value = rng.normal(scale=10.0 ** float(rng.integers(-9, 300)))
            result[at : at + 8] = np.float64(value).tobytes()
        elif result:
            result[at % len(result)] ^= 1 << int(rng.integers(8))
    return bytes(result)


def plain_run(
    seeds: list[bytes], one: Callable[[bytes], bool], runs: int, seed: int
) -> tuple[int, int]:
    """Try so many mutations; returns how many were tried and how many were taken."""
    rng = np.random.default_rng(seed)
    taken = 0
    for _ in range(runs):
        data = mutated(seeds[int(rng.integers(len(seeds)))], rng)
        try:
            taken += one(data)
        except BaseException:
            print(f"the input that failed: {data!r}", file=sys.stderr, flush=True)
            raise
    return runs, taken


def guided_run(part: str, runs: int, seed: int) -> None:
    """Let atheris choose the inputs; it ends the process."""
    import atheris

    with atheris.instrument_imports(include=["lexstack", "lexstack_ros", "yaml"]):
        module = load(part)
    corpus = Path(tempfile.mkdtemp(prefix="lexstack-fuzz-"))
    for number, data in enumerate(module.seeds()):
        (corpus / str(number)).write_bytes(data)
    options = [f"-atheris_runs={runs}", f"-seed={seed or 1}", "-max_len=20000", "-timeout=300"]
    # libFuzzer prints much; its last lines say how many inputs were tried.
    options += ["-print_final_stats=1", "-verbosity=0"]
    atheris.Setup([sys.argv[0], *options, str(corpus)], lambda data: module.one(data) and None)
    atheris.Fuzz()


def load(part: str) -> ModuleType:
    """Return the module of a part."""
    import importlib

    return importlib.import_module(MODULES[part])


def main() -> int:
    """Run the command; returns 0, or 1 where an input made something fail."""
    parser = argparse.ArgumentParser(prog="./scripts/fuzz", description=__doc__)
    parser.add_argument("part", choices=sorted(MODULES), help="what gets the inputs")
    parser.add_argument("--runs", type=int, default=20000, help="inputs (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the random numbers")
    parser.add_argument("--plain", action="store_true", help="without atheris")
    options = parser.parse_args()
    if options.runs < 1 or options.seed < 0:
        parser.error("--runs must be at least 1, --seed at least 0")
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    if options.plain or find_spec("atheris") is None:
        why = "asked for" if options.plain else "atheris is not installed"
        print(f"plain mutations ({why})", flush=True)
        module = load(options.part)
        begun = time.monotonic()
        tried, taken = plain_run(module.seeds(), module.one, options.runs, options.seed)
        took = time.monotonic() - begun
        print(f"{options.part}: {tried} inputs tried, {taken} taken, crashes 0 ({took:.0f} s)")
        return 0
    print(f"guided by atheris: {options.runs} inputs", flush=True)
    guided_run(options.part, options.runs, options.seed)
    return 0


if __name__ == "__main__":
    sys.exit(main())
