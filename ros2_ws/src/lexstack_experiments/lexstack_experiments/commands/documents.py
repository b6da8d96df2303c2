"""``scripts/documents``: tables and figures of the documents, from the results files."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from lexstack.errors import ConfigurationError
from lexstack_experiments.documents.fields import fields_of
from lexstack_experiments.documents.markers import filled
from lexstack_experiments.documents.store import Store

DIFFERS, BAD_ARGUMENT = 1, 2


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns 0, 1 where ``--check`` finds a difference, 2 for what is wrong."""
    root = Path(os.environ.get("LEXSTACK_ROOT", ".")).resolve()
    options = _parser().parse_args(arguments)
    try:
        store = Store(root)
        for run in options.take:
            print(f"wrote {store.take(run).relative_to(root)}")
        changed = changes(root, store)
    except ConfigurationError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_ARGUMENT
    for path, text in changed.items():
        if not options.check:
            path.write_text(text, encoding="utf-8")
        print(f"{'differs' if options.check else 'wrote'} {path.relative_to(root)}")
    return DIFFERS if options.check and changed else 0


def documents(root: Path) -> list[Path]:
    """Return the pages of the repository."""
    return sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md")])


def changes(root: Path, store: Store) -> dict[Path, str]:
    """Return the pages that differ from what the results say, each with its right text."""
    fields, changed = fields_of(store), {}
    for path in documents(root):
        text = path.read_text(encoding="utf-8")
        new = filled(text, fields, str(path.relative_to(root)))
        if new != text:
            changed[path] = new
    return changed


def _parser() -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(
        prog="./scripts/documents",
        description="Write the marked tables and figures of README.md and docs/ from "
        "docs/results/*.json.",
    )
    parser.add_argument(
        "--take",
        type=Path,
        nargs="+",
        default=[],
        metavar="RUN",
        help="first keep the results of these runs of ./scripts/experiment or ./scripts/bench",
    )
    parser.add_argument(
        "--check", action="store_true", help="write no page; exit with 1 where one differs"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
