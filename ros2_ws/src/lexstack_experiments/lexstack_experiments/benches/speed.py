"""All goals of speed in one table: the benches that have them, one after the other, in one run."""

from __future__ import annotations

from dataclasses import replace

from lexstack_experiments.benches import hqp, htmpc, scaling, tick, transition
from lexstack_experiments.benches.goals import figures_of, table_of
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.quiet import Watch
from lexstack_experiments.results import Figure, Results
from lexstack_experiments.text import lines_of

NAME = "speed"
WHOLE = 100
"""Per cent of the cases of every bench."""

_PARTS = {
    "hqp": hqp.EXPERIMENT,
    "transition": transition.EXPERIMENT,
    "tick": tick.EXPERIMENT,
    "scaling": scaling.EXPERIMENT,
    "htmpc": htmpc.EXPERIMENT,
}
_NOTES = (
    "Each row stands for the worst of its figures. A row of a comparison with an earlier version",
    "needs --against FOLDER. The results of each bench are in a folder of its own beside these.",
)


def run(options: Options) -> Results:
    """Run the benches and show every goal."""
    found: dict[str, tuple[Figure, ...]] = {}
    for name, bench in _PARTS.items():
        options.say(f"bench {name}")
        watch = Watch()
        results = replace(bench.run(_share(options, name, bench)), quiet=watch.seen())
        found[name] = results.figures
        folder = options.out / name
        (folder / "results.json").write_text(results.to_json(), encoding="utf-8")
        (folder / "results.txt").write_text("\n".join(lines_of(results)), encoding="utf-8")
    return options.results(
        NAME, figures_of(found), table_of(found), {"benches": list(found)}, _NOTES
    )


def _share(options: Options, name: str, bench: Experiment) -> Options:
    """Return the options of one bench: a share of its cases, a folder of its own."""
    folder = options.out / name
    folder.mkdir()
    cases = max(1, round(bench.cases * options.cases / WHOLE))
    against = options.against if bench.against else None
    peers = options.peers if bench.peers else ()
    return replace(options, out=folder, cases=cases, against=against, peers=peers)


EXPERIMENT = Experiment(
    "all goals of speed in one table: hqp, transition, tick, scaling, htmpc",
    "per cent of each bench",
    WHOLE,
    run,
    peers=hqp.EXPERIMENT.peers,
    against=True,
)
