"""The report's page: everything in one file that loads nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from markupsafe import Markup

from lexstack_bag.figures.figures import STEADY_WINDOW, Metrics
from lexstack_bag.figures.goals import held_back
from lexstack_bag.figures.settling import SETTLED_BAND
from lexstack_bag.report import inline, sequences, tables
from lexstack_bag.report.figure import Figure
from lexstack_bag.report.html import json_text, new_nonce, plot_text, policy, render, trusted
from lexstack_bag.report.layout import with_room
from lexstack_bag.report.pictures import Picture
from lexstack_bag.run.run import Run
from lexstack_bag.run.wholeness import other_parts


def page(
    run: Run,
    metrics: Metrics,
    figures: Sequence[Figure],
    view: Markup,
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
    body = render(
        "report.html",
        metrics=metrics,
        description=run.resolved.scenario.description,
        facts=_facts(run, metrics),
        notes=_notes(run, metrics),
        figures=figures,
        figure_html=figure_html,
        tables=tables,
        held=held_back(metrics),
        sequences=sequences.section(metrics),
        view=view,
        shots=shots,
        no_shots=no_shots,
        steady_window=f"{STEADY_WINDOW:g}",
        settled_band=f"{SETTLED_BAND:g}",
        versions=_versions(run),
    )
    return document(f"{metrics.scenario}: lexstack run", body, three="view3d-data" in view)


def document(title: str, body: str, *, three: bool = False) -> str:
    """Return a whole page with all that it needs in itself.

    Args:
        title: plain text.
        body: HTML, trusted; figures in it are drawn, tables in it can be sorted.
        three: whether a 3-D view is in it.
    """
    libraries = [inline.script(name) for name in ("library.js", "page.js", "tables.js")]
    if three:
        libraries += [inline.three(), inline.script("view3d.js"), inline.script("player.js")]
    nonce = new_nonce()
    return render(
        "document.html",
        title=title,
        body=trusted(body),
        nonce=nonce,
        policy=policy(nonce),
        styles=inline.script("page.css"),
        plotly=inline.plotly(),
        scripts=libraries,
    )


def figure_html(figure: Figure) -> Markup:
    """Return one plot with its heading and caption; only Markup in it is taken for HTML."""
    figure = replace(figure, layout=with_room(figure.layout, figure.traces))
    data = {"data": plot_text(figure.traces), "layout": plot_text(figure.layout)}
    return render("figure.html", figure=figure, data=json_text(data))


def _facts(run: Run, metrics: Metrics) -> dict[str, str]:
    """Return the run's conditions."""
    seconds = metrics.ticks / metrics.rate_hz
    return {
        "mode": metrics.mode,
        "seed": str(metrics.seed),
        "rate": f"{metrics.rate_hz:g} Hz",
        "length": f"{seconds:.2f} s, {metrics.ticks} ticks",
        "robots": ", ".join(run.robots),
        "solver": run.resolved.scenario.solver,
        "bag": run.path.name,
    }


def _notes(run: Run, metrics: Metrics) -> list[str]:
    """Return what a reader must know before any figure."""
    notes = []
    if not run.complete:
        notes.append("The bag ends early: its recorder was killed.")
    if metrics.doubts:
        notes.append(f"No goal is called reached: {'; '.join(metrics.doubts)}.")
    if metrics.gaps:
        notes.append(f"Gaps: {'; '.join(metrics.gaps)}. Lines in the plots are broken there.")
    if metrics.singular:
        notes.append(f"The controller told of singularities. {'; '.join(metrics.singular)}.")
    others = other_parts(run)
    if others:
        notes.append(
            f"A reset of the plant begins a part. This page is about part {run.part} of "
            f"{len(run.parts)} alone; not in its figures are {'; '.join(others)}. "
            "./scripts/analyze writes a report of each part."
        )
    return notes


def _versions(run: Run) -> str:
    """Return the versions that made the run."""
    known = [f"{k} {v}" for k, v in run.provenance.items() if k not in ("name", "mode", "seed")]
    return ", ".join(known) or "versions that the bag does not name"
