"""The robots of a scenario in MuJoCo, led along paths at 1 kHz: no ticks, no commands of ours."""

from __future__ import annotations

import mujoco
import numpy as np

from lexstack.types import Matrix, RobotState, Vector
from lexstack_sim.contacts import touching
from lexstack_sim.impedance import ImpedanceLoop
from lexstack_sim.plant import Plant


class PathLoop(ImpedanceLoop):
    """T(40), of which all but the feedback is worked out for many steps at once."""

    def feed(self, q_star: Matrix) -> Matrix:
        """Return K q* + g at positions q* (k + 1, nq), shape (k, nq): the last one is the next's.

        Gravity is that of q*, and changes along a straight line: in 10 ms a joint turns by some
        hundredths of a radian, and the line is off by the square of that.
        """
        steps = len(q_star) - 1
        first = self._gravity(q_star[0]).copy()
        shares = np.arange(steps)[:, None] / steps
        gravity = first + shares * (self._gravity(q_star[-1]) - first)
        result: Matrix = gravity + self._stiffness * q_star[:-1]
        return result

    def follow(self, q: Vector, v: Vector, feed: Vector, v_star: Vector) -> None:
        """Write the control of the next period; all arguments have shape (nq,)."""
        wanted, scratch, control = self._wanted, self._scratch, self.control
        np.multiply(self._feedforward, v_star, out=wanted)
        wanted += feed
        np.multiply(self._stiffness, q, out=scratch)
        wanted -= scratch
        np.multiply(self._damping, v, out=scratch)
        wanted -= scratch
        np.subtract(control, self._change, out=self._lower)
        np.add(control, self._change, out=self._upper)
        np.maximum(wanted, self._lower, out=wanted)
        np.minimum(wanted, self._upper, out=wanted)
        np.maximum(wanted, self._negative_limit, out=wanted)
        np.minimum(wanted, self._limit, out=control)


class LedPlant(Plant):
    """Robots under joint impedance control, as the bridge's, that follow paths.

    Its team's scenario has a rate of 1 kHz.
    """

    _loop: PathLoop

    @property
    def q(self) -> Vector:
        """The true positions, shape (nq,); written in place."""
        return self._q

    def lead(self, q_star: Matrix, chi: Matrix, torques: Matrix | None = None) -> None:
        """Move the robots by k steps.

        Args:
            q_star: where their drives are at the begin of each step, and after the last one, shape
                (k + 1, nq), m and rad; of bases it has no effect.
            chi: velocities of each step, shape (k, n), m/s and rad/s.
            torques: of arms that take them, shape (k, nq), N m; NaN where there are none.
        """
        data, driving, sensors = self._data, self._driving, self._plant_state.sensors
        q, rates, loop = self._q, self._rates, self._loop
        feed = loop.feed(q_star)
        if self._sensors.slips:
            chi = chi * sensors.grip
        for step in range(len(chi)):
            if self._pushes:
                self._begin_pushes()
            loop.follow(q, rates, feed[step], driving.rates(q, chi[step]))
            if torques is not None:
                given = np.isfinite(torques[step])
                data.ctrl[given] = torques[step][given]
            if self._wrenches:
                self._push()
            if self._obstacles.moving:
                data.mocap_pos[:] = self._obstacles.at(data.time)
            mujoco.mj_step(self.world, data)
            self._read()
            if not self._sensors.perfect:
                self._sensors.see(sensors, q, driving.velocities(q, rates))
            self._plant_state.tick += 1

    def measure(self) -> RobotState:
        """Return what the robots measure now; raises PlantError if it is unstable."""
        memory = self._plant_state
        self._check_stable()
        memory.contacts, memory.contact_force = touching(self.world, self._data)
        self._sensors.measure(
            memory.sensors, self._q, self._driving.velocities(self._q, self._rates)
        )
        return self.state()
