"""Links of the documents, as they have to be in the site."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

# Documents beside docs/ that have a page of the site, and files that are copied into it.
PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
}
EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.py"))
FILES = {
    "LICENSE": "LICENSE.txt",
    "CITATION.cff": "CITATION.cff",
    **{f"examples/{path.name}": f"examples/{path.name}" for path in EXAMPLES},
}

_FENCE = re.compile(r"^(```.*?^```)$", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"(\]\()([^)\s:#]+)((?:#[^)\s]*)?\))")
_PROGRAM = re.compile(r"<!-- program ([\w/.]+) -->")
_MARKER = re.compile(r"<!-- (?:from [\w.-]+|/) -->")


def place(path: str) -> str:
    """Return where a file of the repository is in the site's sources."""
    known = {**PAGES, **FILES}
    return known.get(path, path.removeprefix("docs/"))


def program(path: str) -> str:
    """Return a program as a block of a page; raises OSError where there is none."""
    text = (Path(__file__).resolve().parents[2] / path).read_text(encoding="utf-8")
    return f"```python\n{text.rstrip()}\n```"


def page(text: str, path: str) -> str:
    """Return a document for the site: links as seen from its page, programs in place of markers.

    Args:
        text: the document.
        path: its path in the repository.
    """
    here = posixpath.dirname(path)
    there = posixpath.dirname(place(path))

    def moved(match: re.Match[str]) -> str:
        target = place(posixpath.normpath(posixpath.join(here, match[2])))
        return match[1] + posixpath.relpath(target, there or ".") + match[3]

    text = _PROGRAM.sub(lambda match: program(match[1]), text)
    parts = _FENCE.split(_MARKER.sub("", text))  # every second one is a code block
    return "".join(part if k % 2 else _LINK.sub(moved, part) for k, part in enumerate(parts))
