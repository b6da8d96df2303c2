"""Code blocks that are pictures: equations and diagrams, drawn when the site is built.

The page then holds MathML and SVG, and needs neither a script nor a network.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mermaidx import Diagram
from mkdocs.exceptions import BuildError
from pymdownx.superfences import SuperFencesException

CACHE = Path(__file__).resolve().parents[2] / "build" / "diagrams"


# What the converter leaves of a command or an environment that it does not know.
_UNKNOWN = re.compile(r"<mi>(?:\\|&<)")


class FenceError(SuperFencesException, BuildError):
    """A block that cannot be drawn: pymdownx lets it pass, and mkdocs ends with its text."""


def equation(source: str, *_: Any, **__: Any) -> str:
    """Return a block of LaTeX as MathML; raises FenceError for what is no LaTeX."""
    try:
        html = convert(source, display="block")
    except Exception as error:
        raise FenceError(f"no LaTeX: {source}") from error
    if _UNKNOWN.search(html):
        raise FenceError(f"LaTeX that is not known here: {source}")
    return f'<div class="equation">{html}</div>'


def diagram(source: str, *_: Any, **__: Any) -> str:
    """Return a diagram of mermaid's as SVG; raises FenceError for what is none.

    A diagram takes seconds to draw, so it is kept in ``build/diagrams`` by the hash of its text.
    """
    name = f"diagram-{hashlib.sha256(source.encode()).hexdigest()[:12]}"
    kept = CACHE / f"{name}.svg"
    if not kept.is_file():
        try:
            # Every diagram has the same identifier, and the styles of its SVG refer to it.
            text = Diagram(source).svg().replace("my-svg", name)
        except Exception as error:
            raise FenceError(f"no diagram: {error}\n{source}") from error
        CACHE.mkdir(parents=True, exist_ok=True)
        kept.write_text(text, encoding="utf-8")
    return f'<div class="diagram">{kept.read_text(encoding="utf-8")}</div>'


FENCES = [
    {"name": "math", "class": "math", "format": equation},
    {"name": "mermaid", "class": "mermaid", "format": diagram},
]
