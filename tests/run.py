"""Runs every check: linters, types, the architecture's contracts, then the tests."""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from lexstack_bringup.shared_memory import remove_abandoned
from support.browser import find_browser
from support.leftovers import our_processes, what_is_left

ROOT = Path(__file__).resolve().parents[1]

CHECKS = {
    "lint": ["ruff", "check", "--quiet", "."],
    "format": ["ruff", "format", "--check", "--quiet", "."],
    "types": ["mypy", "--no-error-summary"],
    "architecture": ["lint-imports"],
    "documents": ["scripts/docs"],
    "dependencies": [sys.executable, "tests/dependencies.py"],
}

PARTS = [
    ["tests", "--ignore=tests/system", "--numprocesses=auto", "--dist=worksteal"],
    ["tests/system", "-m", "not realtime and not alone", "--numprocesses=2", "--dist=loadfile"],
    ["tests/system", "-m", "realtime or alone"],
]
"""The parts of the tests, one after another. Tests of a file may share a run: one worker has all.

xdist's groups would be finer, but this pytest does not let it rename tests, and so it sees none.
"""


def run_check(name: str, command: list[str]) -> bool:
    """Run a check, print its outcome on one line, and its output if it failed."""
    start = time.monotonic()
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    outcome = "FAILED" if done.returncode else "ok"
    print(f"{name}: {outcome} ({time.monotonic() - start:.1f} s)", flush=True)
    if done.returncode:
        print(done.stdout + done.stderr, flush=True)
    return done.returncode == 0


def offer_browser() -> None:
    """Install Chromium, which looks at the pages, where root may; else say what stays untested."""
    if find_browser():
        return
    if os.geteuid() == 0 and shutil.which("apt-get"):
        print("installing with apt-get: chromium", flush=True)
        with (ROOT / "build/setup.log").open("ab") as log:
            for command in (["update"], ["install", "-y", "--no-install-recommends", "chromium"]):
                subprocess.run(
                    ["apt-get", *command],
                    env={**os.environ, "DEBIAN_FRONTEND": "noninteractive"},
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=log,
                    check=False,
                )
    if not find_browser():
        print("note: no Chromium: pages are not looked at; install chromium", flush=True)


def run_tests(arguments: list[str]) -> int:
    """Run pytest with the arguments, or all of it where there are none; return the exit code.

    What only computes runs on as many cores as there are. Runs in lockstep take their time and are
    right all the same, so two of them share the machine. What runs in real time needs all of it,
    and comes last and alone.
    """
    variables = {**os.environ, "ROS_PYTHON_CHECK_FIELDS": "1"}
    codes = []
    for chosen in [arguments] if arguments else PARTS:
        command = [sys.executable, "-m", "pytest", "--durations=25", *chosen]
        codes.append(subprocess.run(command, cwd=ROOT, env=variables, check=False).returncode)
        # Processes that tests kill cannot free their memory; nothing runs between the parts.
        remove_abandoned()
    # Not the largest: a pytest that a signal has ended has a negative one.
    return next((code for code in codes if code), 0)


def main() -> int:
    """Run all checks, then pytest with the arguments given; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="./scripts/test",
        description=__doc__,
        epilog="Every other argument goes to pytest, e.g. tests/unit or -k bounds; "
        "paths are relative to the root of the clone.",
    )
    _, arguments = parser.parse_known_args()
    passed = [run_check(name, command) for name, command in CHECKS.items()]
    failed = [name for name, ok in zip(CHECKS, passed, strict=True) if not ok]
    if failed:
        print(f"FAILED before the tests, see above: {', '.join(failed)}", flush=True)
    offer_browser()
    before = our_processes()
    removed = remove_abandoned()
    print(
        f"before the tests: {len(before)} other processes of lexstack, no abandoned shared memory "
        f"({len(removed)} removed)",
        flush=True,
    )
    code = run_tests(arguments)
    left = what_is_left(before)
    print(f"after the tests: {'; '.join(left) or 'no process and no shared memory left'}")
    return code or (1 if failed or left else 0)


if __name__ == "__main__":
    sys.exit(main())
