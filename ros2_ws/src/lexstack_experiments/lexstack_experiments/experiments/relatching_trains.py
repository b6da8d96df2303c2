"""Random trains of what may come in mid-blend, and closed loops that meet them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.references import References
from lexstack.robots import Pose, Team
from lexstack.transition import Announcement, Source, SourceSample, TransitionConfig, quintic
from lexstack.types import RobotState, Vector
from lexstack_config.parts import Parts, home_of
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from lexstack_experiments.runs import changed

BASES = ("track", "reach_base", "posture")
ROBOTS = ("robot_a", "robot_b")

RATE = 100.0  # Hz


@dataclass(frozen=True)
class Train:
    """What comes in a run; ticks are the controller's.

    Attributes:
        mode: lockstep or realtime.
        duration: of every blend [s].
        switches: (tick, stack, robots).
        targets: (tick, robot, offset of the tool from its home [m]).
        lags: after how many ticks the solver has each target, at the controller's tick where it is
            0.
        lead: in which targets are led in [s]; 0: as steps.
        named: whether revisions are known.
        silent: the ticks at which the solver does not answer.
        delays: by how many ticks each answer of the solver is late, by tick.
        until: the first tick with nothing more to come.
    """

    mode: str
    duration: float
    switches: tuple[tuple[int, str, tuple[str, ...]], ...]
    targets: tuple[tuple[int, int, Vector], ...]
    lags: tuple[int, ...]
    lead: float
    named: bool
    silent: frozenset[int]
    delays: NDArray[np.int64]
    until: int

    @property
    def settled(self) -> int:
        """The tick at which every transition must be over, whatever came before.

        Its duration, once more at most that for taking over from a late solver, and what the
        solver's last answers and the lead-in take.
        """
        return self.until + round((2.0 * self.duration + self.lead) * RATE) + 15


def random_train(seed: int, ticks: int, *, named: bool = True) -> Train:
    """Return a train of events until a tick, at up to 60 Hz each.

    ``named``: the solver has the targets at the controller's ticks and names the revision, as the
    processes do. Else it has them some ticks later, and nobody knows.
    """
    rng = np.random.default_rng(seed)
    mode = ["lockstep", "realtime"][seed % 2]
    rates = rng.choice([0.0, 1.0, 7.0, 20.0, 60.0], size=3)  # Hz: targets, losses, switches
    if not rates[2]:
        rates[2] = 0.2
    at = [np.flatnonzero(rng.random(ticks) < rate / RATE) for rate in rates]
    offset, targets = np.zeros((2, 3)), []
    reach = rng.choice([0.005, 0.03, 0.1])
    for tick in at[0]:
        robot = int(rng.integers(2))
        offset[robot] = np.clip(offset[robot] + rng.normal(size=3) * reach, -0.1, 0.1)
        targets.append((int(tick), robot, offset[robot].copy()))
    silent = set[int]()
    longest = max(
        1, min(12, round(50.0 / max(rates[1], 1.0)))
    )  # ticks: the solver is there half the time
    for tick in at[1]:
        silent |= set(range(tick, min(tick + int(rng.integers(1, longest + 1)), ticks)))
    switches = [(1, str(rng.choice(BASES)), ROBOTS)]
    for tick in at[2]:
        robots = ROBOTS if rng.random() < 0.5 else (str(rng.choice(ROBOTS)),)
        switches.append((int(tick) + 2, str(rng.choice(BASES)), robots))
    late = int(rng.choice([0, 0, 2, 8]))
    delays = rng.integers(0, late + 1, ticks)
    lagged = 0 if named else 3
    return Train(
        mode,
        float(rng.choice([0.1, 0.5, 1.0])),
        tuple(switches),
        tuple(targets),
        tuple(rng.integers(0, lagged + 1, len(targets)).tolist()),
        float(rng.choice([0.0, 0.5])),
        named,
        frozenset(silent),
        delays,
        ticks + 2,
    )


class Schedule:
    """References of a train, as steps or led in along a quintic; a schedule for either robot."""

    begun = True  # nothing is measured, and every tick is decided when it comes

    def __init__(self, train: Train, team: Team, home: Vector, *, lagged: bool) -> None:
        """Follow a train; ``lagged``: at the solver's ticks; ``home``: all joints, (n,)."""
        lags = train.lags if lagged else (0,) * len(train.targets)
        self._coming = sorted(
            ((tick + lag, k, robot, offset))
            for k, ((tick, robot, offset), lag) in enumerate(zip(train.targets, lags, strict=True))
        )
        self._train = train
        tools = team.tools(home)
        self._home = tools
        bases = tuple(home[part][:3] for part in team.slices)
        self._now = References(tools, bases)
        self._goals = [tool.position for tool in tools]
        self._begun = [(-1_000_000, tool.position) for tool in tools]
        self._revision = 0

    def decide(self, stamp: float) -> None:
        """Do nothing: ``at`` decides."""

    def at(self, stamp: float) -> References:
        """Return the references of a time [s]."""
        tick = round(stamp * RATE)
        while self._coming and self._coming[0][0] <= tick:
            _, _, robot, offset = self._coming.pop(0)
            self._begun[robot] = (tick, self._now.ee[robot].position)
            self._goals[robot] = self._home[robot].position + offset
            self._revision += 1
        poses = tuple(self._pose(robot, tick) for robot in range(2))
        revision = self._revision if self._train.named else 0
        same = all(a is b for a, b in zip(poses, self._now.ee, strict=True))
        if not same or revision != self._now.revision:
            self._now = References(poses, self._now.base, revision)
        return self._now

    def _pose(self, robot: int, tick: int) -> Pose:
        """Return where a tool shall be at a tick."""
        begun, origin = self._begun[robot]
        now, goal = self._now.ee[robot], self._goals[robot]
        if now.position is goal:
            return now
        passed = (tick - begun + 1) / RATE
        if passed >= self._train.lead:
            return Pose(goal, now.rotation)
        return Pose(origin + quintic(passed / self._train.lead) * (goal - origin), now.rotation)


def with_single_stacks(resolved: ResolvedScenario) -> ResolvedScenario:
    """Return a scenario with ``NAME_ROBOT`` for each of its stacks and robots."""
    stacks = dict(resolved.stacks)
    for name in BASES:
        for robot in ROBOTS:
            single = f"{name}_{robot}"
            stacks[single] = dataclasses.replace(stacks[name], name=single, robots=(robot,))
    return dataclasses.replace(resolved, stacks=stacks)


def run(train: Train, resolved: ResolvedScenario, parts: Parts, *, perfect: bool = False) -> Loop:
    """Return the closed loop after a train, in an exact integrator.

    Args:
        train: what comes.
        resolved: the default scenario; its events are left out.
        parts: of it.
        perfect: whether the solver is always there and in time.
    """
    transition = TransitionConfig(duration=train.duration)
    resolved = changed(resolved, mode=train.mode, transition=transition, events=())
    team, home = parts.team, home_of(parts.team, resolved)
    result = Loop(resolved, IdealPlant(resolved, team), parts=parts)
    result.controller.references = Schedule(train, team, home, lagged=False)  # type: ignore[assignment]
    result.solver_references = Schedule(train, team, home, lagged=not perfect)  # type: ignore[assignment]
    asked: dict[int, list[tuple[str, tuple[str, ...]]]] = {}
    for tick, stack, robots in train.switches:
        asked.setdefault(tick, []).append((stack, robots))
    ask_solver = result.ask_solver
    coming: list[tuple[int, SourceSample]] = []

    def answer(
        wanted: Announcement, state: RobotState, references: References
    ) -> SourceSample | None:
        sample = ask_solver(wanted, state, references)
        if sample is None:
            return None
        revision = references.revision if train.named else None
        return dataclasses.replace(sample, revision=revision)

    def link(sample: SourceSample) -> SourceSample | None:
        if perfect:
            return sample
        tick = sample.tick
        if tick not in train.silent:
            delay = int(train.delays[tick]) if tick < len(train.delays) else 0
            coming.append((tick + delay, sample))
        for entry in [entry for entry in coming if entry[0] <= tick]:
            coming.remove(entry)
            result.controller.transition.hear(entry[1])
        return None

    result.ask_solver, result.link = answer, link
    for tick in range(train.settled + 1):
        for stack, robots in asked.get(tick, ()):
            result.controller.transition.ask(stack, 0.0, "", 0, robots)
        result.step()
    return result


def path_lengths(result: Loop) -> Vector:
    """Return how far each base went [m], shape (robots,)."""
    q = np.array([state.q for state in result.record.states])
    slices = result.parts.team.slices
    return np.array([np.hypot(*np.diff(q[:, part][:, :2], axis=0).T).sum() for part in slices])


def last_blending(result: Loop) -> int:
    """Return the last tick at which a transition was under way; -1: none was."""
    blending = [
        command.tick
        for command in result.record.commands
        if any(state.source is not Source.NONE for state in command.transitions)
    ]
    return max(blending, default=-1)


def still_blending(result: Loop) -> bool:
    """Return whether a transition is under way at the last tick."""
    return last_blending(result) == result.record.commands[-1].tick
