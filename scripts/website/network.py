"""What the pages of a built site would fetch from a network when somebody opens them."""

from __future__ import annotations

import re
from pathlib import Path

# A link is followed when somebody clicks; these are fetched at once.
FETCHED = re.compile(
    r"<(?:script|img|iframe|source|video|audio|embed)\b[^>]*\bsrc=[\"']?((?:https?:)?//[^\"'\s>]+)"
    r"|<link\b(?![^>]*\brel=[\"']?canonical)[^>]*\bhref=[\"']?((?:https?:)?//[^\"'\s>]+)"
    r"|url\([\"']?((?:https?:)?//[^\"')]+)"
    r"|@import [\"']((?:https?:)?//[^\"']+)",
    re.IGNORECASE,
)


def fetched(text: str) -> list[str]:
    """Return the addresses that a page or style sheet fetches."""
    return [next(filter(None, match.groups())) for match in FETCHED.finditer(text)]


def uses(site: Path) -> list[str]:
    """Return page and address of everything in a built site that is not in it."""
    files = sorted(path for path in site.rglob("*") if path.suffix in (".html", ".css"))
    return [
        f"{path.relative_to(site)}: {address}"
        for path in files
        for address in fetched(path.read_text(encoding="utf-8"))
    ]
