"""Where a run stands, as a table in the panel; every text is escaped."""

from __future__ import annotations

from html import escape

from lexstack.types import PlantStatus
from lexstack_ros.view.picture import Picture

_BAD = (PlantStatus.BRAKING, PlantStatus.HOLDING)


def status_table(picture: Picture, rate: float | None) -> str:
    """Return HTML; ``rate`` in ticks per second of wall time, None: not known."""
    plant = picture.plant.name.lower()
    rows = {
        "time": f"{picture.time:.2f} s, tick {picture.tick}"
        + ("" if rate is None else f", {rate:.0f} ticks/s"),
        "plant": _marked(plant) if picture.plant in _BAD else escape(plant),
        "stack": f"<b>{escape(picture.stack)}</b> {escape(picture.phase)}",
        "α": _bar(picture.alpha),
        "to": escape(picture.source),
        "": escape(picture.reason),
        "MPC": "<br>".join(map(escape, picture.sequences)),
    }
    body = "".join(
        f"<tr><td style='padding-right:1em;color:#6B7785'>{name}</td><td>{text}</td></tr>"
        for name, text in rows.items()
        if text
    )
    return _framed(f"<table>{body}</table>")


def answer_line(text: str, *, bad: bool = False) -> str:
    """Return an answer to what was asked as HTML."""
    return _framed(_marked(text) if bad else escape(text))


def _framed(html: str) -> str:
    """Return HTML in the panel's font."""
    return f"<div style='font-size:0.85em;padding:0.2em 0.7em'>{html}</div>"


def _marked(text: str) -> str:
    """Return a text in the colour of what went wrong."""
    return f"<b style='color:#B34700'>{escape(text)}</b>"


def _bar(alpha: float) -> str:
    """Return a progress bar."""
    return f"<progress max='1' value='{alpha:.3f}'></progress> {alpha:.3f}"
