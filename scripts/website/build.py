"""Builds the site of documents into build/site, strictly: a wrong document ends with exit code 1.

Wrong are: a link that leads nowhere, an equation or a diagram that cannot be drawn, a page that is
not in the navigation, a public name without a docstring, and anything that a page would fetch from
a network.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

from website import docstrings, network

ROOT = Path(__file__).resolve().parents[2]


def mkdocs(root: Path, *arguments: str) -> int:
    """Run mkdocs on a clone and return its exit code."""
    command = [sys.executable, "-m", "mkdocs", *arguments, "--config-file", root / "mkdocs.yml"]
    quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}  # of the theme, about its own future
    return subprocess.run(command, cwd=root, env=quiet, check=False).returncode


def build(root: Path) -> int:
    """Build the site of a clone, look at what it came to, and return the exit code."""
    site = root / "build" / "site"
    problems = [f"no docstring: {name}" for name in docstrings.missing(docstrings.api_list(root))]
    code = mkdocs(root, "build", "--strict", "--site-dir", str(site))
    if not code:
        problems += [f"fetched from a network: {use}" for use in network.uses(site)]
    for problem in problems:
        print(problem, file=sys.stderr)
    if code or problems:
        return 1
    print(f"{site.relative_to(root)}/index.html: {len(list(site.rglob('*.html')))} pages")
    return 0


def main() -> int:
    """Build or serve the site; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="./scripts/docs",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--serve",
        metavar="ADDRESS",
        nargs="?",
        const="127.0.0.1:8000",
        help="show the site at this address (default 127.0.0.1:8000), and again after each change",
    )
    arguments = parser.parse_args()
    if arguments.serve:
        return mkdocs(ROOT, "serve", "--dev-addr", arguments.serve)
    return build(ROOT)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
