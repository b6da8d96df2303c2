"""The report's page: everything in one file that loads nothing."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape

from lexstack_bag.metrics import STEADY_WINDOW, Metrics
from lexstack_bag.report import inline, sequences, tables
from lexstack_bag.report.figure import Figure
from lexstack_bag.report.pictures import Picture
from lexstack_bag.run import Run
from lexstack_bag.settling import SETTLED_BAND

# Nothing may come from elsewhere: the browser itself sees to it.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
)


def page(
    run: Run,
    metrics: Metrics,
    figures: Sequence[Figure],
    view: str,
    shots: Sequence[Picture],
    no_shots: str,
) -> str:
    """Return the HTML of the report.

    Args:
        run: the run.
        metrics: its figures.
        figures: the plots, in their order.
        view: the section with the 3-D view, or with the word why there is none.
        shots: the pictures; empty where they could not be rendered.
        no_shots: why there are none.
    """
    first, *others = map(figure_html, figures)
    parts = view + first + _shots(shots, no_shots) + "".join(others) + _topics(metrics)
    return document(
        f"{metrics.scenario}: lexstack run",
        f"{_header(run, metrics, figures)}<main class='wrap'>{_figures_first(metrics)}"
        f"{parts}{footer(run)}</main>",
        three="view3d-data" in view,
    )


def document(title: str, body: str, *, three: bool = False) -> str:
    """Return a whole page with all that it needs in itself.

    Args:
        title: plain text.
        body: HTML; figures in it are drawn, tables in it can be sorted.
        three: whether a 3-D view is in it.
    """
    libraries = [inline.script(name) for name in ("library.js", "page.js", "tables.js")]
    if three:
        libraries += [inline.three(), inline.script("view3d.js"), inline.script("player.js")]
    return (
        "<!DOCTYPE html>\n"
        '<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{inline.script('page.css')}</style></head>\n"
        f"<body>{body}\n{inline.plotly()}\n"
        f"{inline.scripts(*libraries)}\n</body></html>\n"
    )


def _header(run: Run, metrics: Metrics, figures: Sequence[Figure]) -> str:
    """Return title, the run's conditions, and links to the figures."""
    seconds = metrics.ticks / metrics.rate_hz
    facts = {
        "mode": metrics.mode,
        "seed": metrics.seed,
        "rate": f"{metrics.rate_hz:g} Hz",
        "length": f"{seconds:.2f} s, {metrics.ticks} ticks",
        "robots": ", ".join(run.robots),
        "solver": run.resolved.scenario.solver,
        "bag": run.path.name,
    }
    items = "".join(f"<div>{k} <b>{escape(str(v))}</b></div>" for k, v in facts.items())
    links = " ".join(f"<a href='#{f.name}-section'>{f.title.split(':')[0]}</a>" for f in figures)
    cut = "" if run.complete else "<p class='note'>The bag ends early: its recorder was killed.</p>"
    return (
        f"<header><div class='wrap'><h1>{escape(metrics.scenario)}</h1>"
        f"<p class='lead'>{escape(run.resolved.scenario.description)}</p>"
        f"<div class='facts'>{items}</div><nav>{links}</nav>{cut}</div></header>"
    )


def _figures_first(metrics: Metrics) -> str:
    """Return the tables."""
    return (
        "<div class='two'><section id='goals'><h2>The paper and this run</h2>"
        "<p class='caption'>Measured in the simulated plant, from this bag alone. Errors are "
        f"means over the last {STEADY_WINDOW:g} s of a phase, of the worse robot.</p>"
        f"{tables.goals_table(metrics)}</section>"
        f"<section id='run'><h2>The run</h2>{tables.run_table(metrics)}</section></div>"
        "<section id='phases'><h2>Phases</h2><p class='caption'>From one trigger to the next. A "
        f"phase has settled once every error stays within {SETTLED_BAND:g} mm (arm posture: "
        f"{SETTLED_BAND:g} mrad) of its steady state; <i>blend</i> is the time from the trigger "
        "until robot A has taken the stack over. A dash: the stack has no such task.</p>"
        f"{tables.phases_table(metrics)}</section>{sequences.section(metrics)}"
    )


def _shots(shots: Sequence[Picture], reason: str) -> str:
    """Return the pictures, or why there are none."""
    cells = "".join(
        f"<figure><img src='{shot.uri}' alt='The robots in the simulation'>"
        f"<figcaption>{shot.caption}</figcaption></figure>"
        for shot in shots
    )
    return (
        "<section id='pictures'><h2>The two robots at the paper's instants</h2>"
        "<p class='caption'>Rendered from the recorded positions. The small frames are the end "
        "effectors' references.</p>"
        + (f"<div class='shots{' four' if len(shots) == 4 else ''}'>{cells}</div>" if shots else "")
        + (f"<p class='note'>No pictures: {escape(reason)}</p>" if reason else "")
        + "</section>"
    )


def _topics(metrics: Metrics) -> str:
    """Return what was recorded, folded up."""
    return (
        "<section id='messages'><h2>Messages in the bag</h2><details>"
        f"<summary>{len(metrics.messages)} topics</summary>{tables.messages_table(metrics)}"
        "</details></section>"
    )


def figure_html(figure: Figure) -> str:
    """Return one plot with its heading and caption."""
    data = json.dumps({"data": figure.traces, "layout": figure.layout}, separators=(",", ":"))
    data = data.replace("</", "<\\/")  # a closing tag inside the text would end the script
    options = "".join(f"<option>{escape(choice)}</option>" for choice in figure.choices)
    select = f"<label>Joint: <select data-for='{figure.name}'>{options}</select></label>"
    return (
        f"<section id='{figure.name}-section'><h2>{figure.title}</h2>"
        f"<p class='caption'>{figure.caption}</p>{select if figure.choices else ''}"
        f"<div id='{figure.name}' data-linked='{'yes' if figure.linked else 'no'}'></div>"
        f"<script type='application/json' data-figure='{figure.name}'"
        f" data-height='{figure.layout['height']}'>{data}</script></section>"
    )


def footer(run: Run) -> str:
    """Return the versions that made the run."""
    versions = ", ".join(
        f"{key} {value}" for key, value in run.facts.items() if key not in ("name", "mode", "seed")
    )
    return f"<footer>Made with {escape(versions)}.</footer>"
