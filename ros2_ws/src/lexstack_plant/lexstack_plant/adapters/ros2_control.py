"""``plant_adapter``: real robots, or Gazebo's, behind the topics of ros2_control's controllers."""

from __future__ import annotations

import sys
import time
from functools import partial
from pathlib import Path
from time import monotonic

from rclpy.clock import Clock, ClockType
from std_srvs.srv import SetBool

from lexstack.types import RobotState
from lexstack_config.parts import build_team
from lexstack_config.plant_file import check_plant, load_plant
from lexstack_plant.hardware.clocks import SimulatedClock, WallClock
from lexstack_plant.hardware.cycle import HardwareCycle
from lexstack_plant.hardware.memory import HardwareCounters, Phase
from lexstack_plant.hardware.outputs import RobotCommand
from lexstack_plant.hardware.plant import HardwarePlant
from lexstack_plant.hardware.topics import RobotTopics, StateTopics
from lexstack_plant.node import EARLY, PlantNode
from lexstack_plant.pacing import Pacer
from lexstack_plant.topics import PlantTopics
from lexstack_ros.intake.drain import waiting
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import scenario_parameter, text_parameter
from lexstack_ros.node.spin import run_node

_LOOK = 0.2  # s between two looks at who listens
_SLICE = 1e-3  # s between two looks for states when the process ends
_LONGEST = 5.0  # s of braking when the process ends


class PlantAdapter(PlantNode):
    """Robots that follow the controller once each of them is enabled: /NAME/enable."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Connect to the robots of a plant file; raises LexstackError for a wrong parameter."""
        super().__init__("plant_adapter", options)
        resolved = scenario_parameter(self)
        scenario = resolved.scenario
        path = Path(text_parameter(self, "plant", "file of the plant"))
        plant = load_plant(path)
        check_plant(plant, resolved, str(path))
        team = build_team(resolved)
        simulated = plant.use_sim_time
        given = (self, self.look_at_clock, self._rewind)
        clock = SimulatedClock(*given) if simulated else WallClock()
        self._plant = HardwarePlant(resolved, team, plant, self._send, clock.now)
        self._clock_now = clock.now
        pacer = Pacer("realtime", self._plant.period, scenario.timeouts.command_wall)
        last = round(scenario.duration * scenario.rate)
        self._cycle = HardwareCycle(self._plant, pacer, last, self.publish, clock.now)
        self._told = ""
        self._states = states = StateTopics(self, self.refuse)
        self._robots = {
            name: RobotTopics(
                self,
                robot,
                states,
                press=partial(self._press, name),
                stop=plant.safety.stop,
                clock=clock,
                hear=partial(self._plant.hear_joints, name),
            )
            for name, robot in self._plant.robots.items()
        }
        for name in self._robots:
            self.create_service(SetBool, f"{name}/enable", partial(self._on_enable, name))
        self.create_timer(_LOOK, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        topics = PlantTopics(self, team, scenario.rate, tools=False)
        self.begin(team, pacer, self._cycle, topics, run=False, now=clock.now)

    def counters(self) -> HardwareCounters:
        """Return the plant's counters."""
        return self._plant.counters

    def complaint(self) -> str:
        """Return why the robots do not follow the controller, or ''."""
        if self._plant.phase is not Phase.ENABLED:
            return f"{self._plant.phase.value}: {self._plant.reason}"
        status = self._plant.status
        return "" if status == status.FOLLOWING else f"{status.name.lower()}: no command comes"

    def figures(self) -> dict[str, str]:
        """Return what became of the robots' messages."""
        now = self._clock_now()
        figures = {"phase": self._plant.phase.value}
        for name, robot in self._plant.robots.items():
            counters = robot.joints.counters
            figures[f"age of {name}'s joint states [ms]"] = f"{1e3 * robot.joints.age(now):.0f}"
            if robot.base is not None:
                figures[f"age of {name}'s base pose [ms]"] = f"{1e3 * robot.base.age(now):.0f}"
            figures[f"joint states of {name}"] = (
                f"{counters.taken} taken, {counters.repeated} repeated, {counters.late} late, "
                f"{counters.refused} refused"
            )
        return figures

    def look_at_clock(self) -> None:
        """Wake the cycle when its deadline is there.

        What came while this process had no time counts before the tick does: otherwise states look
        stale, and commands missing, that lie in a queue.
        """
        if self._began and self._now() >= self._cycle.deadline - EARLY:
            self._states.take_waiting()
            for command, _ in waiting(self._commands):
                self._take(command)
        super().look_at_clock()

    def publish_more(self, _state: RobotState) -> None:
        """Say once why robots are braked."""
        reason = self._plant.reason
        if reason != self._told and reason:
            self.get_logger().warning(f"{self._plant.phase.value}: {reason}")
        self._told = reason

    def close(self) -> None:
        """Brake the robots, and leave them at zero velocity, before the process ends."""
        self._plant.stop("plant_adapter ends")
        # The executor has ended: states are taken here, for arms that take torques, and the wall's
        # clock must do.
        begun, due = monotonic(), self._clock_now()
        ticks = round(_LONGEST / self._plant.period)
        for tick in range(1, ticks + 1):
            if self._plant.phase is not Phase.STOPPING:
                break
            self._wait(begun + tick * self._plant.period)
            self._plant.step(None, due + tick * self._plant.period)

    def _wait(self, until: float) -> None:
        """Wait for a time of the monotonic clock [s], and hear states meanwhile."""
        while (left := until - monotonic()) > 0.0:
            self._states.take_waiting()
            time.sleep(min(_SLICE, left))

    def _send(self, name: str, command: RobotCommand) -> None:
        """Send a robot its commands of a tick."""
        self._robots[name].send(command)

    def _rewind(self, back: float) -> None:
        """Go on where time went back by so much [s]."""
        self._cycle.rewind(back)

    def _press(self, name: str, pressed: bool) -> None:
        """Take note of an emergency stop."""
        self._plant.press(name, pressed)

    def _look(self) -> None:
        """Look at who listens."""
        for robot in self._robots.values():
            robot.look()

    def _on_enable(
        self, name: str, request: SetBool.Request, response: SetBool.Response
    ) -> SetBool.Response:
        """Enable a robot, or disable it, which brakes all."""
        return self.answer(partial(self._enable if request.data else self._disable, name), response)

    def _enable(self, name: str) -> str:
        """Enable a robot; return what happened, in words."""
        for robot in self._robots.values():
            robot.look()
        if self._cycle.runs and len(self._plant.armed) == len(self._robots) - 1:
            # The controllers begin anew: nothing of before is resumed.
            self._topics.count_reset()
        message = self._cycle.enable(name)
        self.get_logger().info(message)
        return message

    def _disable(self, name: str) -> str:
        """Disable a robot; return what happens, in words."""
        self._plant.disable(name)
        return "all robots are braked, then disabled"


def main() -> int:
    """Run the adapter; returns the exit code."""
    return run_node(PlantAdapter)


if __name__ == "__main__":
    sys.exit(main())
