"""Links of the documents, as they have to be in the site."""

from __future__ import annotations

import posixpath
import re

# Documents beside docs/ that have a page of the site, and files that are copied into it.
PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
}
FILES = {"LICENSE": "LICENSE.txt", "CITATION.cff": "CITATION.cff"}

_FENCE = re.compile(r"^(```.*?^```)$", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"(\]\()([^)\s:#]+)((?:#[^)\s]*)?\))")
_MARKER = re.compile(r"<!-- (?:from [\w.-]+|/) -->")


def place(path: str) -> str:
    """Return where a file of the repository is in the site's sources."""
    known = {**PAGES, **FILES}
    return known.get(path, path.removeprefix("docs/"))


def page(text: str, path: str) -> str:
    """Return a document for the site: its links as seen from its page, without our markers.

    Args:
        text: the document.
        path: its path in the repository.
    """
    here = posixpath.dirname(path)
    there = posixpath.dirname(place(path))

    def moved(match: re.Match[str]) -> str:
        target = place(posixpath.normpath(posixpath.join(here, match[2])))
        return match[1] + posixpath.relpath(target, there or ".") + match[3]

    parts = _FENCE.split(_MARKER.sub("", text))  # every second one is a code block
    return "".join(part if k % 2 else _LINK.sub(moved, part) for k, part in enumerate(parts))
