"""The bridge: the plant in MuJoCo as a ROS node. No mathematics here."""

from __future__ import annotations

import sys
from functools import partial
from time import monotonic

import numpy as np

from lexstack.types import RobotState
from lexstack_config.parts import build_team
from lexstack_interfaces.srv import ApplyWrench
from lexstack_plant.node import PlantNode
from lexstack_plant.options import BridgeOptions
from lexstack_plant.pacing import Pacer
from lexstack_plant.tick_cycle import TickCycle
from lexstack_plant.topics import PlantTopics
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import scenario_parameter
from lexstack_ros.node.spin import run_node
from lexstack_sim.plant import Plant
from lexstack_sim.plant_state import Counters, Status


class SimBridge(PlantNode):
    """The plant of a scenario in MuJoCo, with pushes."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Build the plant of the scenario; raises LexstackError for a wrong parameter."""
        super().__init__("sim_bridge", options)
        resolved = scenario_parameter(self)
        scenario = resolved.scenario
        self._options = BridgeOptions.declare(self)
        team = build_team(resolved)
        self._plant = Plant(resolved, team, scenario.seed)
        for note in self._plant.notes:
            self.get_logger().warning(note)
        pacer = Pacer(scenario.mode, self._plant.period, scenario.timeouts.command_wall)
        last = round(scenario.duration * scenario.rate)
        cycle = TickCycle(self._plant, pacer, last, self.publish, monotonic)
        self._finished = False
        self.create_service(ApplyWrench, "~/apply_wrench", self._on_wrench)
        topics = PlantTopics(self, team, scenario.rate)
        self.begin(team, pacer, cycle, topics, run=not self._options.start_paused)

    def counters(self) -> Counters:
        """Return the plant's counters."""
        return self._plant.counters

    def complaint(self) -> str:
        """Return that no command comes, or ''."""
        status = self._plant.status
        return "" if status == Status.FOLLOWING else f"{status.name.lower()}: no command comes"

    def alarm(self) -> str:
        """Return that the plant brakes for want of a command, or ''."""
        return self.complaint() if self._plant.status == Status.BRAKING else ""

    def figures(self) -> dict[str, str]:
        """Return the force at which robots touch."""
        return {"contact force [N]": f"{self._plant.contact_force:.1f}"}

    def publish_more(self, state: RobotState) -> None:
        """Publish what tools show; end after the last tick."""
        self._topics.publish_for_tools(state, self._plant.effort)
        if self._tick_cycle.ended and not self._finished:
            self.get_logger().info(f"finished: {state.tick} ticks")
            if self._options.exit_at_end:
                self.context.shutdown()
        self._finished = self._tick_cycle.ended

    def _on_wrench(
        self, request: ApplyWrench.Request, response: ApplyWrench.Response
    ) -> ApplyWrench.Response:
        """Push a link from now on."""
        force, torque = request.wrench.force, request.wrench.torque
        push = partial(
            self._plant.apply_wrench,
            request.robot,
            request.link,
            np.array([force.x, force.y, force.z]),
            np.array([torque.x, torque.y, torque.z]),
            request.duration,
        )
        return self.answer(push, response)


def main() -> int:
    """Run the bridge; returns the exit code."""
    return run_node(SimBridge)


if __name__ == "__main__":
    sys.exit(main())
