"""Whole runs with the adapter and the stand-in in place of the bridge, each node a process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rclpy.context import Context

from lexstack_bringup.player import PLAYER, Player
from lexstack_bringup.processes import ADAPTER, arguments_of, bring_up, nodes_of
from lexstack_bringup.real_plant import RealPlant
from lexstack_config.resolved import ResolvedScenario
from lexstack_ros.node.readiness import READY
from lexstack_testing.played_run import ApartRun
from lexstack_testing.ros_session import ros_session

STAND_IN = "stand_in"
_READY = 60.0  # s of wall time


class HardwareRun(ApartRun):
    """Every node a process; the stand-in is one more.

    Attributes:
        real: the robots.
        habits: of the stand-in, as its parameter.
    """

    def __init__(
        self,
        resolved: ResolvedScenario,
        out: Path,
        context: Context,
        real: RealPlant,
        habits: str = "",
    ) -> None:
        """Start nothing yet."""
        self.real, self.habits = real, habits
        super().__init__(real.applied(resolved), out, context)

    def make_player(self) -> Player:
        """Return who enables the robots and plays the scenario."""
        return Player(self.resolved, self.executor, self.context, simulated=False)

    def bring_up(self) -> None:
        """Start the stand-in, then all others, and wait until they are connected."""
        given = {"scenario": str(self.path), "plant": str(self.real.path)}
        if self.habits:
            given["habits"] = f"'{self.habits}'"
        module = "lexstack_testing.stand_in.node"
        self.supervisor.start(STAND_IN, module, arguments_of(STAND_IN, given))
        self.supervisor.wait_printed([STAND_IN], READY, _READY)
        more = {ADAPTER: {"plant": str(self.real.path)}}
        bring_up(self.supervisor, self.path, self.bags[0], peers=[PLAYER], more=more)
        self._connect([self.player], nodes_of(self.resolved.scenario, simulated=False))


@contextmanager
def with_stand_in(
    resolved: ResolvedScenario, out: Path, real: RealPlant, habits: str = ""
) -> Iterator[HardwareRun]:
    """Yield a run whose processes are up; leave none behind."""
    with ros_session(children=True) as context:
        run = HardwareRun(resolved, out, context, real, habits)
        try:
            run.bring_up()
            yield run
        finally:
            run.end()
            run.executor.shutdown()
            run.player.destroy_node()
