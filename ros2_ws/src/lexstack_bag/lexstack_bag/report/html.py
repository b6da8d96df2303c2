"""Makes HTML and the data in it: whatever a message may say stays text.

Every page comes from a template with autoescape: a plain text is escaped where it is put in, a
``Markup`` is HTML of our own. The same holds for texts in plots, where plotly.js knows a few tags.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

_NONCE_BYTES = 18
# Letters with a meaning in HTML: inside of strings JSON has other ways to write them.
_ESCAPES = {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026"}


def render(template: str, **values: Any) -> Markup:
    """Return the HTML of one of our templates, by its file's name."""
    return trusted(_environment().get_template(template).render(values))


def render_text(template: str, **values: Any) -> Markup:
    """Return the HTML of a template's text, which is our own."""
    return trusted(_environment().from_string(template).render(values))


def trusted(html: str) -> Markup:
    """Return HTML of our own, with nothing in it that comes from elsewhere unescaped."""
    return Markup(html)  # noqa: S704 - the only place; callers give what they wrote themselves


def json_text(value: Any) -> Markup:
    """Return JSON that may stand in a script element: no letter of it ends the element."""
    text = json.dumps(value, separators=(",", ":"))
    for letter, escaped in _ESCAPES.items():
        text = text.replace(letter, escaped)
    return trusted(text)


def plot_text(value: Any) -> Any:
    """Return data for plotly.js with every text escaped in it that is no Markup."""
    if isinstance(value, Mapping):
        return {key: plot_text(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plot_text(item) for item in value]
    if isinstance(value, str) and not isinstance(value, Markup):
        return value.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return value


def new_nonce() -> str:
    """Return a word that nobody can know beforehand: scripts without it do not run."""
    return secrets.token_urlsafe(_NONCE_BYTES)


def policy(nonce: str, *more: str) -> Markup:
    """Return a Content-Security-Policy: scripts with the nonce, and nothing from elsewhere.

    Styles stay open, since plotly.js writes its own into the page.

    Args:
        nonce: of this page's scripts.
        more: further directives.
    """
    rules = (
        "default-src 'none'",
        f"script-src 'nonce-{nonce}'",
        "style-src 'unsafe-inline'",
        "img-src data: blob:",
        "base-uri 'none'",
        "form-action 'none'",
        *more,
    )
    return trusted("; ".join(rules))


@lru_cache(maxsize=1)
def _environment() -> Environment:
    """Return what reads our templates."""
    return Environment(
        loader=PackageLoader("lexstack_bag.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
