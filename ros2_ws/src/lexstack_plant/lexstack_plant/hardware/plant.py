"""Real robots as a plant of the controllers: ticks in, commands out, and a guard. No ROS."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from lexstack.control import CommandRules
from lexstack.errors import InputError
from lexstack.robots import Team
from lexstack.types import PlantStatus, RobotState, Vector
from lexstack_config.plant_file import PlantFile
from lexstack_config.resolved import ResolvedScenario
from lexstack_plant.hardware.braking import SmoothBrake
from lexstack_plant.hardware.guard import Guard
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.outputs import RobotCommand
from lexstack_plant.hardware.robot import HardwareRobot
from lexstack_sim.impedance import per_joint

_ACCEPTED = 1e-3  # relative, by which a command may exceed a limit: that of the solver's tolerance
_FORGETS = 1.0  # s, in which the difference between commanded and measured velocities is forgotten
_STILL = 0.02  # rad/s and m/s: slower joints are taken to be at rest when they are taken over

Send = Callable[[str, RobotCommand], None]
"""Sends a robot, by its name, its commands of a tick."""


class Phase(Enum):
    """Whether robots are commanded."""

    DISABLED = "disabled"  # nothing is sent
    ENABLED = "enabled"  # they follow the controller
    STOPPING = "stopping"  # they are braked, and disabled when they are at rest


@dataclass(slots=True)
class HardwareCounters:
    """Ticks since the robots were enabled in which something was not as it should be."""

    missing: int = 0  # no command came
    refused: int = 0  # the command exceeded a limit
    clamped: int = 0  # q* had run away from q and was pulled back
    late: int = 0  # the tick was late by more than a period


@dataclass(slots=True)
class HardwareMemory:
    """What the adapter remembers between ticks; vectors have shape (n,)."""

    q_star: Vector
    command: Vector
    change: Vector  # of the command at the last tick
    q: Vector
    v: Vector
    in_flight: Vector  # how far commands on their way will move the robots
    slip: Vector  # what the commands lead farther than the measured velocities, of late
    tick: int = 0
    silence: int = 0
    status: PlantStatus = PlantStatus.FOLLOWING
    due: float = field(default=-np.inf)  # s by the local clock, of the last tick


class HardwarePlant:
    """All robots of a plant file, enabled and disabled together.

    Attributes:
        team: the robots.
        period: the control period [s].
        robots: by name, with their intakes.
        phase: whether they are commanded.
        reason: why they are not, or will not be; '' while they are.
        armed: the robots that were enabled; all must be before one moves.
        counters: what went wrong since they were enabled.
        seed: of nothing: a real plant is as it is.
    """

    def __init__(
        self,
        resolved: ResolvedScenario,
        team: Team,
        plant: PlantFile,
        send: Send,
        clock: Callable[[], float],
        accepted: float = _ACCEPTED,
    ) -> None:
        """Make the plant, disabled.

        Args:
            resolved: the scenario, whose rate is the plant's.
            team: the robots of the scenario.
            plant: where they are reached.
            send: takes the commands of each tick.
            clock: monotonic [s].
            accepted: relative, by which a command may exceed a limit; others stop the robots.
        """
        scenario = resolved.scenario
        self.team = team
        self.period = 1.0 / scenario.rate
        self.seed = 0
        watchdog = round(scenario.timeouts.watchdog / self.period)
        self.robots = {
            model.name: HardwareRobot(
                model,
                plant.robots[model.name],
                plant.safety,
                self.period,
                watchdog,
                shared=plant.use_sim_time,
            )
            for model in team.robots
        }
        self.phase, self.reason = Phase.DISABLED, "not enabled yet"
        self.armed: set[str] = set()
        self.counters = HardwareCounters()
        self._places: Mapping[str, Vector] = {
            name: np.array(place.base) for name, place in scenario.robots.items()
        }
        self._silence = watchdog + round(plant.safety.silence / self.period)
        self._stale = plant.safety.stale
        self._guard = Guard(team, plant.safety)
        self._brake = SmoothBrake(team.limits, self.period)
        distance = per_joint(team, "q_star_distance", "q_star_distance")
        self._rules = CommandRules(
            team.limits,
            self.period,
            watchdog,
            distance,
            lambda chi: self._brake(chi, self._m.change),
        )
        self._send, self._clock, self._accepted = send, clock, accepted
        self._arms = np.concatenate(
            [np.arange(model.n) >= model.arm.start for model in team.robots]
        )
        nothing = np.zeros(team.n)
        self._m = HardwareMemory(*(nothing.copy() for _ in range(7)))

    # ---- the protocol of a plant

    @property
    def status(self) -> PlantStatus:
        """What the plant did in its last tick."""
        return self._m.status

    @property
    def resting(self) -> bool:
        """Whether nothing is sent."""
        return self.phase is Phase.DISABLED

    def state(self) -> RobotState:
        """Return the state of this tick.

        Its q is where the robots will be when the next command begins to act: as measured when the
        tick began, and moved on by the commands that are on their way. So the controllers see
        robots without delay, and keep position limits at any delay of the outputs.
        """
        m = self._m
        return RobotState(
            m.tick,
            m.tick * self.period,
            _frozen(m.q + m.in_flight),
            _frozen(m.v),
            _frozen(m.q_star),
            _frozen(m.command),
        )

    def look(self) -> RobotState:
        """Measure now, while nothing is sent, and return the state: at rest, where it is."""
        m = self._m
        self._measure(self._clock())
        if self.resting:
            m.q_star[:], m.command[:], m.change[:], m.in_flight[:] = m.q, 0.0, 0.0, 0.0
        return self.state()

    def step(self, chi: Vector | None, due: float | None = None) -> RobotState:
        """Send the command of a tick, and return the state of the next one.

        Args:
            chi: the command, shape (n,), m/s and rad/s; None: none came.
            due: when the tick ends, by the local clock [s]; None: now.
        """
        m, now = self._m, self._clock()
        due = now if due is None else due
        before = m.command.copy()
        if self.phase is Phase.ENABLED:
            self._accept(chi)
        if self.phase is Phase.STOPPING:
            self._rules.brake(m)
        m.change[:] = m.command - before
        self._catch_up(before, due)
        m.q_star += self.period * m.command
        m.slip += self.period * (before - m.v) - self.period / _FORGETS * m.slip
        for model, part, robot in self._parts():
            robot.push(m.command[part])
            # While robots are braked their states may be wrong: a platform is where it was led.
            q = m.q if self.phase is Phase.ENABLED else m.q_star
            self._send(model, robot.command(m.command[part], q[part], due))
        m.tick, m.due = m.tick + 1, due
        self._measure(now)
        if self.phase is Phase.ENABLED:
            fault = self._fault(now)
            if fault:
                self.stop(fault)
        elif not m.command.any() and not m.change.any():
            self.phase = Phase.DISABLED
        self.counters.clamped += self._rules.bound(m, self._known())
        return self.state()

    def hear_joints(self, name: str, sample: JointSample) -> None:
        """Take a message of a robot's joints; an arm that takes torques is sent the next ones.

        Raises:
            InputError: it is no sample.
        """
        robot, m = self.robots[name], self._m
        taken = robot.joints.counters.taken
        robot.joints.hear(sample)
        if robot.effort is None or self.resting or robot.joints.counters.taken == taken:
            return
        now = self._clock()
        part = self.team.slices[self.team.index(name)]
        q, v = robot.measured(now)
        # Between two ticks q* goes on along the command in force.
        passed = min(max(now - m.due, 0.0), self.period)
        ahead = m.q_star[part] + (passed - self.period) * m.command[part]
        torques = robot.effort.torques(q, v, ahead, m.command[part])
        self._send(name, RobotCommand(now, values=torques))

    # ---- who may move

    def enable(self, name: str) -> bool:
        """Arm a robot; when all are armed, begin. Return whether they have begun.

        Raises:
            InputError: the robot is unknown, or may not move now, and why.
        """
        robot = self._robot(name)
        if self.phase is not Phase.DISABLED:
            raise InputError(f"the robots are {self.phase.value}")
        now = self._clock()
        robot.forget()
        self._check(name, now)
        self.armed.add(name)
        if len(self.armed) < len(self.robots):
            return False
        try:
            for other in self.robots:
                self._check(other, now)
        except InputError:
            self.armed.clear()
            raise
        self._begin(now)
        return True

    def disable(self, name: str, reason: str = "") -> None:
        """Disarm a robot: all are braked. Raises InputError if it is unknown."""
        self._robot(name)
        self.stop(reason or f"{name} was disabled")

    def stop(self, reason: str) -> None:
        """Brake all robots, and disable them when they are at rest; the first reason counts."""
        self.armed.clear()
        if self.phase is Phase.ENABLED:
            self.phase, self.reason = Phase.STOPPING, reason

    def press(self, name: str, pressed: bool) -> None:
        """Take note of a robot's emergency stop."""
        robot = self._robot(name)
        robot.pressed = pressed
        if pressed:
            self.stop(f"{name}: emergency stop")

    # ---- inside

    def _robot(self, name: str) -> HardwareRobot:
        """Return a robot; raises InputError."""
        if name not in self.robots:
            raise InputError(f"unknown robot {name!r}; known: {', '.join(self.robots)}")
        return self.robots[name]

    def _parts(self) -> list[tuple[str, slice, HardwareRobot]]:
        """Return every robot's name, part of chi, and topics."""
        return [
            (name, part, self.robots[name])
            for name, part in zip(self.team.names, self.team.slices, strict=True)
        ]

    def _check(self, name: str, now: float) -> None:
        """Raise InputError if a robot may not move now."""
        robot = self.robots[name]
        wrong = robot.wrong(now)
        if wrong:
            raise InputError(wrong)
        if robot.base is not None:
            robot.base.place(self._places[name])
        q, v = self._m.q.copy(), np.zeros(self.team.n)
        part = self.team.slices[self.team.index(name)]
        q[:] = np.clip(0.0, self.team.limits.position_lower, self.team.limits.position_upper)
        q[part], v[part] = robot.measured(now)
        unready = self._guard.unready(q, v)
        if unready:
            raise InputError(unready)

    def _begin(self, now: float) -> None:
        """Begin at the measured state: nothing of before is left."""
        m = self._m
        self.counters = HardwareCounters()
        self._measure(now)
        limit = self.team.limits.velocity
        # A user's own controller may move the robot: ours begins with its velocity. What a robot
        # at rest measures as velocity is noise.
        m.command[:] = np.where(np.abs(m.v) > _STILL, np.clip(m.v, -limit, limit), 0.0)
        m.q_star[:], m.change[:], m.slip[:] = m.q, 0.0, 0.0
        m.tick, m.silence, m.status, m.due = 0, 0, PlantStatus.FOLLOWING, now
        for _, part, robot in self._parts():
            robot.begin(m.q[part], m.command[part])
            m.in_flight[part] = robot.in_flight(m.command[part])
        m.q_star += m.in_flight
        self.phase, self.reason = Phase.ENABLED, ""

    def _accept(self, chi: Vector | None) -> None:
        """Follow a command, hold without one; stop at one beyond the limits, or after silence."""
        m = self._m
        if chi is None:
            self.counters.missing += 1
            self._rules.miss(m)
            if m.silence > self._silence:
                self.stop(f"no commands for {self._silence * self.period:.2g} s")
            return
        fast, sudden = self._rules.exceeded(m, chi, self._accepted)
        if fast or sudden:
            self.counters.refused += 1
            change = np.abs(chi - m.command) / self._rules.step_limit
            over = np.maximum(np.abs(chi) / self.team.limits.velocity, change)
            i = int(np.argmax(over))
            what = "velocity" if fast else "acceleration"
            self.stop(
                f"the command exceeds the {what} limit of {self.team.joint_names[i]} "
                f"{over[i]:.3g} times"
            )
            return
        self._rules.follow(m, chi)

    def _catch_up(self, before: Vector, due: float) -> None:
        """Let the outputs go on through ticks that were left out, as their consumers have.

        A trajectory says by itself how it goes on: at its last velocity for the watchdog's time.
        """
        gap = due - self._m.due - self.period
        if gap < 0.5 * self.period or not np.isfinite(gap):
            return
        self.counters.late += 1
        ticks = round(gap / self.period)
        hold = 2 + round(self._stale / self.period)
        for _ in range(min(ticks, hold)):
            for _, part, robot in self._parts():
                robot.push(before[part])
        if ticks > hold:
            self.stop(f"the adapter stood still for {1e3 * gap:.0f} ms")

    def _measure(self, now: float) -> None:
        """Read the measured state of all robots; where nothing is known the last one stays."""
        m = self._m
        for _, part, robot in self._parts():
            q, v = robot.measured(now)
            known = np.isfinite(q)
            m.q[part] = np.where(known, q, m.q[part])
            m.v[part] = np.where(known, v, 0.0)
            if self.phase is Phase.DISABLED:
                continue
            m.in_flight[part] = robot.in_flight(m.command[part])
            if self.phase is Phase.ENABLED and not robot.wrong(now):
                # Wheels slip: where a platform was led is where it is.
                base = robot.platform
                m.q_star[part][base] = m.q[part][base] + m.in_flight[part][base]

    def _known(self) -> Vector:
        """Return the measured q, or q* while the robots are braked: states may be wrong then."""
        m = self._m
        return m.q + m.in_flight if self.phase is Phase.ENABLED else m.q_star

    def _fault(self, now: float) -> str:
        """Return why the robots must be stopped, or ''."""
        m = self._m
        alone = next((wrong for r in self.robots.values() if (wrong := r.wrong(now))), "")
        if alone:
            return alone
        return self._guard.beyond(m.q, m.v) or self._guard.lost(self._away())

    def _away(self) -> Vector:
        """Return how far each joint is from where it is led, shape (n,).

        An arm may be led to positions. A platform is led by velocities, and its pose may be
        corrected by whoever measures it: there the way that it did not make lately counts.
        """
        away = self._m.slip.copy()
        for model, part, robot in zip(
            self.team.robots, self.team.slices, self.robots.values(), strict=True
        ):
            led = robot.output.led
            if led is not None:
                away[part][model.arm] = led - self._m.q[part][model.arm]
        return away


def _frozen(values: Vector) -> Vector:
    """Return a copy that cannot be written."""
    result = np.array(values)
    result.setflags(write=False)
    return result
