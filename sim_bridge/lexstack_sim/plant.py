"""The plant: all robots of a scenario in MuJoCo, stepped one control tick at a time. No ROS."""

from __future__ import annotations

import copy
from collections.abc import Callable

import mujoco
import numpy as np

from lexstack.control import CommandRules
from lexstack.errors import ConfigurationError, InputError
from lexstack.robots import Team
from lexstack.types import RobotState, Vector
from lexstack_config.parts import home_of
from lexstack_config.plant import PushConfig
from lexstack_config.resolved import ResolvedScenario
from lexstack_sim.contacts import touching
from lexstack_sim.coordinates import Coordinates
from lexstack_sim.driving import Driving
from lexstack_sim.impedance import ImpedanceLoop, TorqueLoop, per_joint
from lexstack_sim.notes import notes
from lexstack_sim.payload_friction import add_payload_friction
from lexstack_sim.plant_state import Counters, PlantError, PlantState, Snapshot, Status
from lexstack_sim.sensors import Sensors
from lexstack_sim.world import PHYSICS_PERIOD, build_world
from lexstack_sim.wrench import Wrench, apply_wrenches, wrench_on

_ALL = int(mujoco.mjtState.mjSTATE_INTEGRATION)
_DIVERGED = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)


class Plant:
    """Robots under joint impedance control that take one chi per tick.

    Attributes:
        team: the robots.
        period: the control period [s].
        world: the MuJoCo model.
        counters: what went wrong so far.
        seed: of everything random in the plant.
        notes: what is not simulated as the robots' files say, one line each.
    """

    def __init__(
        self,
        resolved: ResolvedScenario,
        team: Team,
        seed: int = 0,
        start: Vector | None = None,
        loop: Callable[[Team, float, Vector], TorqueLoop] = ImpedanceLoop,
    ) -> None:
        """Build the world of a scenario and put the robots where they start.

        Args:
            resolved: the scenario.
            team: its robots.
            seed: of everything random in the plant.
            start: where they start, shape (nq,), m and rad; None: where the scenario says.
            loop: makes what controls the actuators.

        Raises:
            ConfigurationError: the control period is not a multiple of the physics step, or a
                push is on an unknown robot.
            InputError: a push is on an unknown link.
        """
        scenario = resolved.scenario
        self.team = team
        self.period = 1.0 / scenario.rate
        self._steps = round(self.period / PHYSICS_PERIOD)
        if self._steps < 1 or abs(self._steps * PHYSICS_PERIOD - self.period) > 1e-9:
            raise ConfigurationError(
                f"scenario {scenario.name}: rate: the period must be a multiple of "
                f"{1e3 * PHYSICS_PERIOD:g} ms, got {1e3 * self.period:g} ms"
            )
        self._home = home_of(team, resolved) if start is None else start
        self._rules = CommandRules(
            team.limits,
            self.period,
            round(scenario.timeouts.watchdog / self.period),
            per_joint(team, "q_star_distance", "q_star_distance"),
        )
        self.notes = notes(team, self._home)
        self.world = build_world(team)
        self._data = mujoco.MjData(self.world)
        add_payload_friction(self.world, self._data, team, scenario.plant)
        self._sensors = Sensors(scenario.plant, team, PHYSICS_PERIOD)
        self._pushes = [
            (round(push.at / self.period), self._wrench(push)) for push in scenario.plant.pushes
        ]
        self._obstacles = team.obstacles
        self._loop = loop(team, PHYSICS_PERIOD, self._data.ctrl)
        self._coordinates = Coordinates(self.world, team)
        direct = self._coordinates.direct
        self._driving = Driving(team)
        self._q: Vector = self._data.qpos if direct else np.zeros(team.nq)
        self._rates: Vector = self._data.qvel if direct else np.zeros(team.nq)  # q'
        self.reset(seed)

    def reset(self, seed: int = 0) -> RobotState:
        """Put the robots where the scenario starts, at rest, at tick 0; return that state."""
        self.seed = seed
        n = self.team.n
        mujoco.mj_resetData(self.world, self._data)
        self._coordinates.put(self._data, self._home)
        self._read()
        self._loop.reset(self._home)
        self._plant_state = PlantState(
            self._home.copy(),
            np.zeros(n),
            self._data.ctrl.copy(),
            self._sensors.begin(self._home, seed),
        )
        self._wrenches: list[Wrench] = []
        self.counters = Counters()
        return self.state()

    @property
    def status(self) -> Status:
        """What the plant did in its last tick."""
        return self._plant_state.status

    @property
    def effort(self) -> Vector:
        """Forces of the actuators in the last physics step along q, shape (nq,), N and N m."""
        return _frozen(self._plant_state.effort)

    @property
    def contacts(self) -> int:
        """Points at which robots touched others, or obstacles, in the last physics step."""
        return self._plant_state.contacts

    @property
    def contact_force(self) -> float:
        """Sum of the normal forces at these points [N]."""
        return self._plant_state.contact_force

    def state(self) -> RobotState:
        """Return the present state, as far as it is measured."""
        plant_state = self._plant_state
        return RobotState(
            tick=plant_state.tick,
            stamp=plant_state.tick * self.period,
            q=_frozen(plant_state.sensors.q),
            v=_frozen(plant_state.sensors.v),
            q_star=_frozen(plant_state.q_star),
            command=_frozen(plant_state.command),
        )

    def step(self, chi: Vector | None) -> RobotState:
        """Advance by one control period and return the new state.

        Args:
            chi: the command, shape (n,), m/s and rad/s; None: none came. The plant applies also a
                command beyond the limits, as a real one would, and counts it.

        Raises:
            InputError: chi has a wrong length or is not finite; the plant has not moved.
            PlantError: the simulation became unstable.
        """
        if chi is None:
            self._miss()
        else:
            self._follow(self._checked(chi))
        self._advance()
        return self.state()

    def apply_wrench(
        self, robot: str, link: str, force: Vector, torque: Vector, duration: float
    ) -> None:
        """Push a link for ``duration`` [s] from now: force [N] and torque [N m], world axes.

        Raises:
            ConfigurationError: the robot is unknown.
            InputError: the link is unknown, or a value is not finite.
        """
        if not (np.isfinite(duration) and duration > 0.0):
            raise InputError(f"wrench: duration: must be finite and > 0, got {duration}")
        model = self.team.robots[self.team.index(robot)]
        end = self._data.time + duration - 0.5 * PHYSICS_PERIOD
        self._wrenches.append(wrench_on(self.world, model, link, force, torque, end))

    def save(self) -> Snapshot:
        """Return all that the plant's future depends on."""
        physics = np.empty(mujoco.mj_stateSize(self.world, _ALL))
        mujoco.mj_getState(self.world, self._data, physics, _ALL)
        return Snapshot(
            physics,
            copy.deepcopy(self._plant_state),
            copy.copy(self.counters),
            tuple(self._wrenches),
        )

    def restore(self, snapshot: Snapshot) -> RobotState:
        """Go back to a saved state; what follows is the same to the bit."""
        mujoco.mj_setState(self.world, self._data, snapshot.physics, _ALL)
        self._read()
        self._plant_state = copy.deepcopy(snapshot.plant_state)
        self.counters = copy.copy(snapshot.counters)
        self._wrenches = list(snapshot.wrenches)
        return self.state()

    def _checked(self, chi: Vector) -> Vector:
        """Return chi as floats; raises InputError."""
        values = np.asarray(chi, dtype=np.float64)
        if values.shape != (self.team.n,):
            raise InputError(f"chi: expected {self.team.n} values, got shape {values.shape}")
        if not np.isfinite(values).all():
            i = int(np.flatnonzero(~np.isfinite(values))[0])
            raise InputError(f"chi: value {i} is {values[i]}")
        return values

    def _follow(self, chi: Vector) -> None:
        """Take a command over, and count what a well-behaved controller never sends."""
        fast, sudden = self._rules.exceeded(self._plant_state, chi)
        self.counters.over_velocity += fast
        self.counters.over_acceleration += sudden
        self._rules.follow(self._plant_state, chi)

    def _miss(self) -> None:
        """Keep the last command for the watchdog's time, then slow down within the limits."""
        self.counters.missing += 1
        self._rules.miss(self._plant_state)

    def _advance(self) -> None:
        """Run the physics of one tick; q* moves along the command (first-order hold)."""
        plant_state, data = self._plant_state, self._data
        q, rates, command = self._q, self._rates, plant_state.command
        driving, sensors = self._driving, plant_state.sensors
        increment = PHYSICS_PERIOD * command
        self._begin_pushes()
        for _ in range(self._steps):
            # At the measured yaw, so that a differential base is never sent to its side.
            wanted = (
                command if driving.straight or not self._sensors.slips else sensors.grip * command
            )
            self._loop.update(q, rates, plant_state.q_star, driving.rates(q, wanted))
            if driving.straight and self._sensors.slips:
                data.ctrl *= sensors.grip
            if self._wrenches:
                self._push()
            if self._obstacles.moving:
                data.mocap_pos[:] = self._obstacles.at(data.time)
            mujoco.mj_step(self.world, data)
            self._read()
            if driving.straight:
                plant_state.q_star += increment
            else:
                plant_state.q_star[:] = self.team.integrate(
                    plant_state.q_star, command, PHYSICS_PERIOD
                )
            if not self._sensors.perfect:
                self._sensors.see(sensors, q, driving.velocities(q, rates))
        self._sensors.measure(sensors, q, driving.velocities(q, rates))
        self._check_stable()
        self.counters.clamped += self._rules.bound(plant_state, q)
        plant_state.tick += 1
        plant_state.effort[:] = data.actuator_force
        plant_state.contacts, plant_state.contact_force = touching(self.world, data)
        self.counters.contact += plant_state.contacts > 0

    def _check_stable(self) -> None:
        """Raise PlantError if the simulation has become unstable."""
        if any(self._data.warning[kind].number for kind in _DIVERGED):
            raise PlantError(f"the simulation became unstable at {self._data.time:.3f} s")

    def _read(self) -> None:
        """Read the joints of q, and put those that mimic them where these are."""
        if self._coordinates.direct:
            return  # q and q' are MuJoCo's own vectors
        self._coordinates.read(self._data, self._q, self._rates)
        self._coordinates.couple(self._data, self._q, self._rates)

    def _begin_pushes(self) -> None:
        """Begin the scenario's pushes that are due at this tick."""
        self._wrenches += [push for tick, push in self._pushes if tick == self._plant_state.tick]

    def _wrench(self, push: PushConfig) -> Wrench:
        """Return a push of the scenario."""
        robot = self.team.robots[self.team.index(push.robot)]
        end = push.at + push.duration - 0.5 * PHYSICS_PERIOD
        return wrench_on(self.world, robot, push.link, np.array(push.force), np.zeros(3), end)

    def _push(self) -> None:
        """Apply the wrenches that have not ended."""
        self._wrenches = [wrench for wrench in self._wrenches if self._data.time < wrench.end]
        apply_wrenches(self.world, self._data, self._wrenches)


def _frozen(values: Vector) -> Vector:
    """Return a copy that cannot be written."""
    result = np.array(values)
    result.setflags(write=False)
    return result
