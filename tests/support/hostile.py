"""Texts that would run as a script, or break a page, wherever they are not escaped."""

from __future__ import annotations

from support.browser import Browser

IMAGE = "<img src=x onerror=window.hacked=1>"
SCRIPT = "</script><script>window.hacked=1</script>"
QUOTES = "\"'><svg onload=window.hacked=1>"
COMMENT = "<!--<script>"
LINK = "<a href='https://evil.example'><b>link</b></a>"  # plotly.js would draw it as one
PLACES = "{{ 7 * 7 }}{% for x in y %}%{y}"
ALL = LINK + IMAGE + SCRIPT + QUOTES + COMMENT + PLACES


def assert_harmless(page: Browser) -> None:
    """Assert that a page shows such texts as texts: no element was made of them, nothing ran."""
    made = (
        "[...document.querySelectorAll('img[src=x], svg[onload], [onerror], [onload], "
        "a[href*=evil], a[*|href*=evil]')].length"
    )
    assert page.run(made) == 0
    assert page.run("window.hacked") is None
    # A script that the policy stopped is in the page all the same.
    foreign = (
        "[...document.scripts].filter(s => s.type === '' && "
        "s.textContent.trim() === 'window.hacked=1').length"
    )
    assert page.run(foreign) == 0
    assert page.messages == []  # an inline script that the policy refuses is told here


def shown(page: Browser, text: str) -> bool:
    """Return whether a text stands in the page, letter by letter."""
    return bool(page.run(f"document.body.textContent.includes({text!r})"))
