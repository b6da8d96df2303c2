"""What docs/experiments-htmpc.md says of the experiments of paper H."""

from __future__ import annotations

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import digits, reached, table

_PATHS = ("HT path m", "ST path m", "ST by height m", "least m")


def _waypoints(store: Store) -> str:
    """Return the row of every height, the lowest first."""
    rows = []
    for row in sorted(store["waypoint-path"].rows(), key=lambda row: row["height m"]):
        share = row["HT / ST"]
        rows.append(
            [
                f"{row['height m']:.1f}",
                *(f"{row[name]:.2f}" for name in _PATHS),
                f"{share:.3f}" if abs(share - 1.0) < 0.005 else f"{share:.2f}",
                *(f"{row[name]:.1f}" for name in ("HT s", "ST s")),
                *(f"{row[name]:.2f}" for name in ("HT nearest m", "reach m")),
            ]
        )
    columns = ["height m", *_PATHS, "HT / ST", "HT s", "ST s", "HT's base nearest m", "reach m"]
    return table(columns, rows)


def _deliveries(store: Store) -> str:
    """Return the row of every layout, speed and set of weights."""
    rows = []
    for row in store["delivery"].rows():
        ours = row["weights"] == "lexstack"
        speed = "at once" if row["tool m/s"] is None else f"{row['tool m/s']:g} m/s"
        share = f"{row['ST / HT']:.2f}"
        goal = ours and row["layout"] == "table" and row["tool m/s"] is not None
        rows.append(
            [
                *((row["layout"], speed) if ours else ("", "")),
                ("**ours**" if goal else "ours") if ours else "authors'",
                *(f"{row[name]:.1f}" for name in ("HT s", "ST s")),
                f"**{share}**" if goal else share,
                *(digits(row[name]) for name in ("HT path m", "ST path m")),
            ]
        )
    columns = ["layout", "tool", "weights", "HT s", "ST s", "ST / HT", "HT path m", "ST path m"]
    return table(columns, rows)


def _constraints(store: Store) -> str:
    """Return the error of the tool under each constraint, for three sets of weights."""
    results, rows = store["lexicographic-constraints"], []
    for (constraint, delta), base in _BASE.items():
        mine = {
            row["weights"]: row
            for row in results.rows()
            if (row["constraint"], row["delta mm"]) == (constraint, delta)
        }
        paper = mine["authors"]["paper: EE / std, base"].split(",")[0] or "–"
        cells = [
            f"{_error(mine[name]['EE mm'])} / {_error(mine[name]['std mm'])}"
            for name in ("authors", "authors, second", "lexstack")
        ]
        rows.append([f"{constraint}, {delta:g} mm", paper, *cells, base])
    columns = ["constraint, δ", "EE mean / std mm: paper", "authors' weights"]
    return table(
        [*columns, "their second weights", "ours", "base, their second weights"],
        rows,
    )


# What the base does with the authors' second weights: read off the picture.
_BASE = {
    ("H(12)", 1.0): "within 5 % in both parts",
    ("H(12)", 10.0): "within 5 % in both parts, sooner",
    ("H(11)", 1.0): "hardly leaves; part 2 diverges",
    ("H(11)", 10.0): "part 2 diverges",
    ("H(11) per stage", 1.0): "hardly leaves; part 2 diverges",
    ("H(11) per stage", 10.0): "part 2 diverges",
}


def _error(value: float) -> str:
    """Return a length [mm] with two decimals, above 10 mm with one."""
    return f"{value:.1f}" if value >= 10.0 else f"{value:.2f}"


def _tool(store: Store) -> str:
    """Return the goals of ``lexicographic-constraints``."""
    results = store["lexicographic-constraints"]
    mean, peak = (results.figure(f"Ours: EE error, {name}") for name in ("mean", "peak"))
    off = [
        results.figure(f"Ours: base off its optimum in part {part}, of the initial error")
        for part in (1, 2)
    ]
    failed = results.figure("Ours: failed solves")
    rows = [
        ["EE error, mean", f"{mean['paper']} mm", "≤ 1 mm", f"{mean['value']:.2f} mm"],
        ["EE error, peak", "–", "≤ 10 mm", f"{peak['value']:.1f} mm"],
        *(
            [f"base off its optimum, part {part}", "≤ 5 %", "≤ 5 %", f"{100 * each['value']:.3f} %"]
            for part, each in enumerate(off, 1)
        ),
        ["failed solves", "–", "0", f"{failed['value']:.0f}"],
    ]
    figures = (mean, peak, *off, failed)
    lines = [[*row, reached(figure)] for row, figure in zip(rows, figures, strict=True)]
    return table(["figure", "paper", "goal", "ours", ""], lines)


def _reactions(store: Store) -> str:
    """Return the figures of ``reactivity``."""
    results = store["reactivity"]
    held = results.figure("EE error of a row while held, largest")
    base = results.figure("Base before the release, fastest")
    missed, failed = results.figure("Targets not reached"), results.figure("Failed solves")
    back, served = (
        " / ".join(_time(results.figure(f"{name}, {which}")["value"]) for which in _SPREAD)
        for name in ("Jump to back within 20 mm", "Release to the next served")
    )
    rows = [
        ["EE error while held, any row, largest", "base stops in time", "≤ δ = 10 mm",
         f"{held['value']:.2f} mm", reached(held)],
        ["base in the last second before the release", "stops", "≤ 0.02 m/s",
         f"{base['value']:.3f} m/s", reached(base)],
        ["targets not reached", "all reached", "0", f"{missed['value']:.0f}", reached(missed)],
        ["failed solves", "–", "0", f"{failed['value']:.0f}", reached(failed)],
        ["jump to back within 20 mm, median / longest", "in the video", "–", f"{back} s", ""],
        ["release to the next person served, median / longest", "–", "–", f"{served} s", ""],
    ]  # fmt: skip
    return table(["figure", "paper", "goal", "ours", ""], rows)


_SPREAD = ("median", "longest")


def _time(value: float) -> str:
    """Return a time [s] with two digits."""
    return f"{value:.2f}" if value < 1.0 else f"{value:.1f}"


FIELDS = {
    "waypoint-path.table": _waypoints,
    "delivery.table": _deliveries,
    "delivery.ratio": lambda store: digits(store["delivery"].rows()[0]["ST / HT"], 2),
    "lexicographic-constraints.goals": _tool,
    "lexicographic-constraints.table": _constraints,
    "reactivity.table": _reactions,
}
