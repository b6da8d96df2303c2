"""The page of a sweep: limits with their confidence, quantiles, and the spread of every figure."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

import numpy as np
import pyarrow as pa
from markupsafe import Markup

from lexstack.types import Vector
from lexstack_bag.report.figure import Figure
from lexstack_bag.report.html import render_text
from lexstack_bag.report.layout import single
from lexstack_bag.report.page import document, figure_html
from lexstack_bag.report.tables import table as html_table
from lexstack_experiments.sweeps.storage import INDEX
from lexstack_experiments.sweeps.summary import failures, figures_of, limits_kept, quantiles
from lexstack_experiments.sweeps.sweep_file import SweepFile

_SHOWN_FAILURES = 20
_HEIGHT = 260  # px
_BODY = """
<header><div class='wrap'><h1>{{ name }}</h1><p class='lead'>{{ description }}</p>
<p class='note'>{{ facts }}</p></div></header>
<main class='wrap'><h2>Limits</h2>
<p>Bound: of the chance that a run breaks the limit, at 95 % confidence (Clopper and Pearson).</p>
{{ limits }}
<h2>Figures of the runs</h2>{{ figures }}
{% if failed %}<h2>Runs that could not be done</h2>{{ failed }}{% endif %}
{% for plot in plots %}{{ plot }}{% endfor %}
</main>
"""


def page(sweep: SweepFile, runs: pa.Table, facts: str) -> str:
    """Return the HTML of a sweep's report, which loads nothing.

    Args:
        sweep: what was run.
        runs: its table.
        facts: where and on which commit it was made, in a sentence.
    """
    figures = figures_of(runs, sweep)
    body = render_text(
        _BODY,
        name=sweep.name,
        description=sweep.description,
        facts=facts,
        limits=_limits(sweep, runs),
        figures=_quantiles(figures),
        failed=_failures(runs),
        plots=[figure_html(_plot(name, each, sweep, runs)) for name, each in figures.items()],
    )
    return document(f"{sweep.name}: lexstack sweep", body)


def _limits(sweep: SweepFile, runs: pa.Table) -> Markup:
    """Return the table of limits."""
    rows = [
        [
            kept.figure,
            kept.limit,
            str(kept.runs),
            str(kept.broken),
            f"{kept.bound:.2g}",
            str(kept.worst),
        ]
        for kept in limits_kept(runs, sweep)
    ]
    head = ["figure", "limit", "runs", "broken", "bound", "run nearest to it or beyond"]
    return html_table(head, rows, "limits")


def _quantiles(figures: Mapping[str, Vector]) -> Markup:
    """Return the table of quantiles."""
    rows = [[name, *(f"{q:.4g}" for q in quantiles(each))] for name, each in figures.items()]
    return html_table(
        ["figure", "p50", "p90", "p99", "largest"], [r for r in rows if len(r) > 1], "q"
    )


def _failures(runs: pa.Table) -> Markup | None:
    """Return the table of the first runs that failed, if any."""
    rows = [[str(index), text] for index, text in failures(runs)]
    return html_table(["run", "reason"], rows[:_SHOWN_FAILURES], "failed") if rows else None


def _plot(name: str, figures: Vector, sweep: SweepFile, runs: pa.Table) -> Figure:
    """Return how a figure spreads: of all runs of each combination of the grid."""
    combination = runs[INDEX].to_numpy() // sweep.runs
    chosen = sweep.combinations
    traces = []
    for number in np.unique(combination):
        part = figures[(combination == number) & np.isfinite(figures)]
        label = ", ".join(f"{key} {value}" for key, value in chosen[number].items()) or "all runs"
        fraction = (np.arange(part.size) + 1.0) / max(part.size, 1)
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "line": {"shape": "hv"},
                "name": label,
                "x": np.sort(part).tolist(),
                "y": fraction.tolist(),
            }
        )
    layout = single(name, "part of the runs", _HEIGHT)
    caption = "Part of the runs whose figure is at most this."
    return Figure(f"plot-{escape(name)}", name, caption, traces, layout, linked=False)
