"""Our controllers on robots with the habits of hardware: errors, and drives that refuse steps.

The adapter of ros2_control and its stand-in, without ROS between them, in simulated time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from lexstack_config.parts import Parts
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.hardware_cases import (
    HABITS,
    Switch,
    plant_of,
    sequence,
    switches,
)
from lexstack_experiments.loop import Loop
from lexstack_experiments.measuring import largest
from lexstack_experiments.results import Figure, Peer, Results, Table, zero
from lexstack_experiments.runs import analysed, scenario_of
from lexstack_testing.stand_in.habits import parse_habits
from lexstack_testing.stand_in.in_process import HardwareInProcess

NAME = "hardware"
_SWITCHES = 100
_METHODS = ("bridge", "instant_limited", "instant")


@dataclass
class Tally:
    """What became of switches by one method."""

    switches: int = 0
    reflexes: int = 0  # of the drives, with every command passed on
    refused: int = 0  # stopped by the adapter, before the drives had to
    acceleration: float = 0.0  # peak of what the drives were asked for / limit
    jerk: float = 0.0
    reasons: tuple[str, ...] = ()


def run(options: Options) -> Results:
    """Run the sequence with each habit, and switches at random by each method."""
    rows = list(_sequences(options, sequence(options.config)))
    configured = list(_sequences(options, scenario_of(options.config)))
    tallies = {method: _tally(options, method) for method in _METHODS}
    ours, instant = tallies["bridge"], tallies["instant"]
    everything = next((row for row in rows if row["habits"] == "all"), None)
    bridge = rows[0]
    figures = [
        Figure(
            name,
            everything[name] if everything else None,
            "mm",
            None,
            "",
            Peer("MuJoCo", bridge[name]),
        )
        for name in ("EE after (A) mm", "base after (A) mm", "final EE mm")
    ]
    return options.results(
        NAME,
        (
            zero("Reflex stops by our transition", ours.reflexes),
            zero("Stops by the adapter, our transition", ours.refused),
            Figure("Reflex stops by instant switching", instant.reflexes),
            *figures,
        ),
        (
            Table.of(rows, "the task sequence, robot B's last goal turned by 0.1 rad"),
            Table.of(configured, "the task sequence as it is configured"),
            Table.of(
                [
                    {
                        "method": method,
                        "switches": tally.switches,
                        "reflex stops": tally.reflexes,
                        "stopped by the adapter": tally.refused,
                        "acc. ratio": tally.acceleration,
                        "jerk ratio": tally.jerk,
                    }
                    for method, tally in tallies.items()
                ],
                "random switches, all habits",
            ),
        ),
        {"plant": "MuJoCo at 1 kHz behind messages", "rate_hz": 100.0, "states_hz": 125.0},
        (
            "acc. and jerk ratio: peak of what the drives were asked for at 1 kHz / limit.",
            "stopped by the adapter: counted in runs of their own, in which it checks commands.",
        ),
    )


def _sequences(options: Options, resolved: ResolvedScenario) -> Iterator[dict[str, Any]]:
    """Yield the errors of a task sequence: in MuJoCo alone, then with each habit."""
    plant = plant_of(options.config)
    parts = Parts.of(resolved)
    loop = Loop(resolved, parts=parts)
    loop.run()
    yield _row("MuJoCo alone", loop, "")
    options.say("sequence in MuJoCo alone")
    wanted = list(HABITS.items())[-max(1, min(options.cases, len(HABITS))) :]
    for name, habits in wanted:
        hardware = HardwareInProcess(
            resolved, parts.team, plant, parse_habits(habits), options.seed
        )
        loop = Loop(resolved, plant=hardware, parts=parts)
        _run(loop, hardware)
        stopped = "; ".join(hardware.robots.stopped().values()) or hardware.adapter.reason
        options.say(f"sequence with {name}: {stopped or 'done'}")
        yield _row(name, loop, stopped)


def _run(loop: Loop, hardware: HardwareInProcess) -> None:
    """Run a loop to its end, or until the robots are stopped."""
    scenario = loop.resolved.scenario
    for _ in range(round(scenario.duration * scenario.rate)):
        loop.step()
        if hardware.adapter.reason or hardware.robots.stopped():
            break


def _row(habits: str, loop: Loop, stopped: str) -> dict[str, Any]:
    """Return the figures of one run of the sequence; of one that was stopped there are none."""
    names = ("EE after (A) mm", "base after (A) mm", "final EE mm", "settled")
    values: Sequence[float | None] = (None,) * len(names)
    if not stopped:
        metrics = analysed(loop).metrics
        first, last = metrics.phases[1], metrics.phases[-1]
        values = (
            largest((first.ee_error_mm or {}).values()),
            largest((first.base_error_mm or {}).values()),
            largest((last.ee_error_mm or {}).values()),
            sum(phase.settled_s is not None for phase in metrics.phases[1:]),
        )
    at = loop.record.states[-1].stamp
    why = f"at {at:.2f} s: {stopped}" if stopped else "no"
    return {"habits": habits, **dict(zip(names, values, strict=True)), "stopped": why}


def _tally(options: Options, method: str) -> Tally:
    """Count what becomes of switches by a method, with all habits."""
    tally = Tally()
    for switch in switches(options.config, method, options.seed, min(options.cases, _SWITCHES)):
        tally.switches += 1
        hardware = _played(options, switch, check=False)
        peaks = [robot.drive.peaks for robot in hardware.robots.robots.values()]
        tally.acceleration = max(tally.acceleration, *(peak[1] for peak in peaks))
        tally.jerk = max(tally.jerk, *(peak[2] for peak in peaks))
        tally.reflexes += bool(hardware.robots.stopped())
        if method != "instant":
            tally.refused += bool(hardware.adapter.reason)
        elif _played(options, switch, check=True).adapter.counters.refused:
            tally.refused += 1
    options.say(f"{method}: {tally.reflexes} reflex stops in {tally.switches} switches")
    return tally


def _played(options: Options, switch: Switch, *, check: bool) -> HardwareInProcess:
    """Return the robots after a switch, or after they were stopped."""
    parts = Parts.of(switch.resolved)
    hardware = HardwareInProcess(
        switch.resolved,
        parts.team,
        plant_of(options.config),
        parse_habits("all"),
        options.seed,
        check=check,
    )
    _run(Loop(switch.resolved, plant=hardware, parts=parts), hardware)
    return hardware


EXPERIMENT = Experiment(
    "the task sequence and random switches on robots with the habits of hardware",
    "switches, and habits",
    _SWITCHES,
    run,
)
"""Registered under its name."""
