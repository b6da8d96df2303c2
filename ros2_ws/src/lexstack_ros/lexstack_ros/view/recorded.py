"""Pictures of a recorded run, by the same words and rules as those of a run under way."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from lexstack.types import Matrix, Vector
from lexstack_bag.run.references import references_in_effect
from lexstack_bag.run.run import Run
from lexstack_interfaces.msg import Chi, PlantState, SequenceStatus, TransitionStatus
from lexstack_ros.messages.conversions import to_time
from lexstack_ros.view.heard import COMMANDER, SOURCE, Heard, picture_of
from lexstack_ros.view.picture import WINDOW, Curves, Picture, curves

_SAMPLES = 200  # of a plot
_OLD = 1.0  # s of simulated time after which a plan is no longer followed


class Recorded:
    """What the page shows of a bag.

    Attributes:
        team: the robots.
        time: of each recorded state of the plant [s], shape (T,), ascending.
    """

    def __init__(self, run: Run) -> None:
        """Take a run with at least one state of the plant."""
        self._run, self.team = run, run.team()
        self.time: Vector = run.plant.stamp

    def row(self, time: float) -> int:
        """Return the row of the last state at a time [s], or of the first."""
        return max(0, int(np.searchsorted(self.time, time + 1e-9, "right")) - 1)

    def picture(self, row: int, *, plans: bool = True) -> Picture:
        """Return what is shown of a state; without ``plans`` no horizons of the MPC."""
        plant, tick = self._run.plant, int(self._run.plant.tick[row])
        state = PlantState(tick=tick, q=plant.q[row].tolist(), status=int(plant.status[row]))
        state.header.stamp = to_time(float(plant.stamp[row]))
        heard = Heard(
            state,
            self._statuses(tick),
            self._chi(tick),
            self._horizons(row) if plans else {},
            self._progress(tick),
        )
        goals = self._references[row]
        return picture_of(self.team, heard, goals, goals)

    def curves(self, row: int) -> Curves:
        """Return the plots of the time before a state."""
        first = self.row(float(self.time[row]) - WINDOW)
        rows = np.unique(np.linspace(first, row, min(_SAMPLES, row - first + 1)).astype(int))
        return curves([self.picture(int(one), plans=False) for one in rows])

    @cached_property
    def _references(self) -> tuple[Any, ...]:
        """The goals at every state."""
        return references_in_effect(self._run, self.team)

    def _statuses(self, tick: int) -> list[TransitionStatus]:
        """Return the statuses of the last tick up to one."""
        stream = self._run.transition
        last = np.flatnonzero(stream.tick <= tick)[-1:]
        return [
            TransitionStatus(
                tick=int(stream.tick[row]),
                from_stack=str(stream.from_stack[row]),
                to_stack=str(stream.to_stack[row]),
                source=str(stream.source[row]),
                phase=int(stream.phase[row]),
                alpha=float(stream.alpha[row]),
                reason=str(stream.reason[row]),
                robots=str(stream.robots[row]).split() if len(stream.robots) else [],
            )
            for row in np.flatnonzero(stream.tick == (stream.tick[last[0]] if len(last) else -1))
        ]

    def _chi(self, tick: int) -> dict[str, Chi]:
        """Return the last solution of each controller up to a tick."""
        found = {}
        for name in (COMMANDER, SOURCE):
            stream = self._run.chi.get(name)
            row = -1 if stream is None else int(np.searchsorted(stream.tick, tick, "right")) - 1
            if stream is not None and row >= 0:
                slacks = stream.slacks[row]
                found[name] = Chi(
                    tick=int(stream.tick[row]),
                    slacks=slacks[np.isfinite(slacks)].tolist(),
                    solve_time=float(stream.solve_time[row]),
                )
        return found

    def _horizons(self, row: int) -> dict[int, Matrix]:
        """Return where the tools go by the last plans before a state."""
        now, found = float(self.time[row]), {}
        for name, topics in self._run.plan_topics.items():
            plans, robot = topics.plans, self.team.index(name)
            last = int(np.searchsorted(plans.stamp, now + 1e-9, "right")) - 1
            if last < 0 or now - plans.stamp[last] > _OLD:
                continue
            begin = np.flatnonzero(self._run.plant.tick == plans.tick[last])
            if len(begin):
                q = self._run.plant.q[begin[0], self.team.q_slices[robot]]
                path = self._path(robot, q, plans.times[last], plans.velocity[last])
                found[robot] = path
        return found

    def _path(self, robot: int, q: Vector, times: Vector, velocity: Vector) -> Matrix:
        """Return the positions of a tool over a plan's horizon, shape (m, 3), m.

        Accelerations are constant between two states of a plan, so its positions follow from the
        mean of their velocities.
        """
        model = self.team.robots[robot]
        times = times[np.isfinite(times)]
        velocities = velocity.reshape(-1, model.n)[: len(times)]
        points = [model.tool(q)[0].position]
        for k, step in enumerate(np.diff(times)):
            q = model.integrate(q, 0.5 * (velocities[k] + velocities[k + 1]), float(step))
            points.append(model.tool(q)[0].position)
        return np.array(points)

    def _progress(self, tick: int) -> list[SequenceStatus]:
        """Return where the sequences stand at a tick."""
        found = []
        ticks = _OLD * self._run.resolved.scenario.rate
        for name, topics in self._run.plan_topics.items():
            stream = topics.progress
            row = int(np.searchsorted(stream.tick, tick, "right")) - 1
            if row >= 0 and tick - stream.tick[row] <= ticks:
                found.append(
                    SequenceStatus(
                        robot=name,
                        index=int(stream.index[row]),
                        count=int(stream.count[row]),
                        task=str(stream.task[row]),
                        error=float(stream.error[row]),
                        solve_time=float(stream.solve_time[row]),
                    )
                )
        return found
