"""Real robots as a plant of the controllers: ticks in, commands out, and a guard. No ROS."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lexstack.errors import InputError
from lexstack.robots import Team
from lexstack.types import PlantStatus, RobotState, Vector
from lexstack_config.plant_file import PlantFile
from lexstack_config.resolved import ResolvedScenario
from lexstack_plant.hardware.commands import Commands
from lexstack_plant.hardware.guard import Guard
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.memory import HardwareCounters, HardwareMemory, Phase
from lexstack_plant.hardware.outputs import RobotCommand
from lexstack_plant.hardware.robots import HardwareRobots
from lexstack_plant.hardware.takeover import Takeover

_ACCEPTED = 1e-3  # relative, by which a command may exceed a limit: that of the solver's tolerance
_FORGETS = 1.0  # s, in which the difference between commanded and measured velocities is forgotten

Send = Callable[[str, RobotCommand], None]
"""Sends a robot, by its name, its commands of a tick."""


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
        self._all = HardwareRobots(team, plant, watchdog)
        self.robots = self._all.named
        self.phase, self.reason = Phase.DISABLED, "not enabled yet"
        self.armed: set[str] = set()
        self.counters = HardwareCounters()
        self._m = HardwareMemory.empty(team.nq, team.n)
        silence = watchdog + round(plant.safety.silence / self.period)
        self._commands = Commands(team, self._m, watchdog, silence, accepted)
        self._rules = self._commands.rules
        self._guard = Guard(team, plant.safety)
        places = {name: np.array(place.base) for name, place in scenario.robots.items()}
        self._takeover = Takeover(self._all, self._guard, places)
        self._stale = plant.safety.stale
        self._send, self._clock = send, clock

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
            _frozen(self._all.coming(m)),
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
            self._stop_if(self._commands.accept(chi, self.counters))
        if self.phase is Phase.STOPPING:
            self._rules.brake(m)
        m.change[:] = m.command - before
        self._catch_up(before, due)
        m.q_star[:] = self.team.integrate(m.q_star, m.command, self.period)
        m.slip += self.period * (before - m.v) - self.period / _FORGETS * m.slip
        # While robots are braked their states may be wrong: a platform is where it was led.
        where = m.q if self.phase is Phase.ENABLED else m.q_star
        for model, at, part, robot in self._all.parts():
            robot.push(m.command[part])
            self._send(model.name, robot.command(m.command[part], where[at], due))
        m.tick, m.due = m.tick + 1, due
        self._measure(now)
        if self.phase is Phase.ENABLED:
            self._stop_if(self._fault(now))
        elif not m.command.any() and not m.change.any():
            self.phase = Phase.DISABLED
        known = self._all.coming(m) if self.phase is Phase.ENABLED else m.q_star
        self.counters.clamped += self._rules.bound(m, known)
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
        at, part = self._all.part(name)
        q, v = robot.measured(now)
        # Between two ticks q* goes on along the command in force.
        passed = min(max(now - m.due, 0.0), self.period)
        ahead = robot.model.integrate(m.q_star[at], m.command[part], passed - self.period)
        torques = robot.effort.torques(q, v, ahead, m.command[part])
        self._send(name, RobotCommand(now, values=torques))

    # ---- who may move

    def enable(self, name: str) -> bool:
        """Arm a robot; when all are armed, begin. Return whether they have begun.

        Raises:
            InputError: the robot is unknown, or may not move now, and why.
        """
        robot = self._all.find(name)
        if self.phase is not Phase.DISABLED:
            raise InputError(f"the robots are {self.phase.value}")
        now = self._clock()
        robot.forget()
        self._takeover.check(name, self._m, now)
        self.armed.add(name)
        if len(self.armed) < len(self.robots):
            return False
        try:
            for other in self.robots:
                self._takeover.check(other, self._m, now)
        except InputError:
            self.armed.clear()
            raise
        self.counters = HardwareCounters()
        self._takeover.begin(self._m, now)
        self.phase, self.reason = Phase.ENABLED, ""
        return True

    def disable(self, name: str, reason: str = "") -> None:
        """Disarm a robot: all are braked. Raises InputError if it is unknown."""
        self._all.find(name)
        self.stop(reason or f"{name} was disabled")

    def stop(self, reason: str) -> None:
        """Brake all robots, and disable them when they are at rest; the first reason counts."""
        self.armed.clear()
        if self.phase is Phase.ENABLED:
            self.phase, self.reason = Phase.STOPPING, reason

    def press(self, name: str, pressed: bool) -> None:
        """Take note of a robot's emergency stop."""
        robot = self._all.find(name)
        robot.pressed = pressed
        if pressed:
            self.stop(f"{name}: emergency stop")

    # ---- inside

    def _stop_if(self, fault: str) -> None:
        """Stop for a reason, if there is one."""
        if fault:
            self.stop(fault)

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
            self._all.push(before)
        if ticks > hold:
            self.stop(f"the adapter stood still for {1e3 * gap:.0f} ms")

    def _measure(self, now: float) -> None:
        """Read the measured state, and what is on its way where commands are sent."""
        self._all.measure(self._m, now)
        if self.phase is not Phase.DISABLED:
            self._all.look_ahead(self._m, now, trusted=self.phase is Phase.ENABLED)

    def _fault(self, now: float) -> str:
        """Return why the robots must be stopped, or ''."""
        m = self._m
        return (
            self._all.wrong(now)
            or self._guard.beyond(self.team.joint_positions(m.q), m.v)
            or self._guard.lost(self._all.away(m))
        )


def _frozen(values: Vector) -> Vector:
    """Return a copy that cannot be written."""
    result = np.array(values)
    result.setflags(write=False)
    return result
