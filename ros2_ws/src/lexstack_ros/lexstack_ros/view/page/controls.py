"""The buttons: each asks for what any user may ask for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import viser

from lexstack.errors import InputError
from lexstack_ros.view.orders import (
    LINKS,
    Cancel,
    Known,
    Order,
    Pause,
    Release,
    Reset,
    Step,
    Stop,
    one_of,
)  # fmt: skip

SWITCH, PUSH, PLANT, SEQUENCES, ENABLE = "switch", "push", "plant", "sequences", "enable"
"""What a run may offer; enabling is offered robot by robot, as ``enable NAME``."""
_EXAMPLE = """name: my_stack
description: tools at their targets, then rest
levels:
- tasks: [{type: ee_pose}]
- tasks: [{type: velocity_damping}]
"""


class Controls:
    """The panel's folders of buttons; what nobody serves is hidden."""

    def __init__(
        self,
        server: viser.ViserServer,
        known: Known,
        ask: Callable[[Order], None],
        refuse: Callable[[str], None],
    ) -> None:
        """Make them all; arguments are those of ``Targets``."""
        self._gui, self._known, self._ask, self._refuse = server.gui, known, ask, refuse
        self._offered: dict[str, list[Any]] = {}
        self._stacks()
        self._targets()
        self._push()
        self._plant()
        if known.sequences:
            self._sequences()
        self.offer(())

    def offer(self, services: Collection[str]) -> None:
        """Show the buttons of what is served, and hide the others."""
        for name, handles in self._offered.items():
            for handle in handles:
                if handle.visible != (name in services):
                    handle.visible = name in services
        self._plant_folder.visible = any(
            name == PLANT or name.startswith(ENABLE) for name in services
        )

    def know_stacks(self, names: Sequence[str]) -> None:
        """Offer other stacks, as users send them; what is chosen stays."""
        if tuple(names) != tuple(self._known.stacks):
            self._known = replace(self._known, stacks=tuple(names))
            self._stack.options = tuple(names)

    def _stacks(self) -> None:
        """Add the switch of stacks, and the field for one that is written on the page."""
        with self._gui.add_folder("Stack", order=20) as folder:
            self._stack = stack = self._gui.add_dropdown("to", tuple(self._known.stacks))
            duration = self._gui.add_number("in [s]", 0.0, min=0.0, max=60.0, step=0.1)
            self._buttons(
                "",
                {
                    "Switch stack": lambda: self._known.switch(stack.value, duration.value),
                    "Cancel": Cancel,
                },
            )
        with self._gui.add_folder("Stack as text", order=22, expand_by_default=False) as written:
            text = self._gui.add_text("YAML", _EXAMPLE, multiline=True)
            self._buttons(
                "",
                {"Switch to text": lambda: self._known.switch_to_text(text.value, duration.value)},
            )
        self._offered[SWITCH] = [folder, written]

    def _targets(self) -> None:
        """Add targets by numbers, for who knows them."""
        robots = tuple(self._known.robots)
        with self._gui.add_folder("Target by numbers", order=40, expand_by_default=False):
            robot = self._gui.add_dropdown("robot", robots)
            place = self._gui.add_vector3("base: x, y [m], yaw [rad]", (0.0, 0.0, 0.0), step=0.05)
            position = self._gui.add_vector3("tool: x, y, z [m]", (0.4, 0.0, 0.9), step=0.05)
            turn = self._gui.add_text("tool: qx, qy, qz, qw", "1, 0, 0, 0")
            self._buttons(
                "send",
                {
                    "Base": lambda: self._known.base_target(robot.value, place.value),
                    "Tool": lambda: self._known.tool_target(
                        robot.value, position.value, _floats(turn.value, "orientation")
                    ),
                },
            )

    def _push(self) -> None:
        """Add the push of a link."""
        with self._gui.add_folder("Push", order=50, expand_by_default=False) as folder:
            robot = self._gui.add_dropdown("robot", tuple(self._known.robots))
            link = self._gui.add_dropdown("link", LINKS)
            force = self._gui.add_vector3("force [N]", (0.0, 40.0, 0.0), step=1.0)
            duration = self._gui.add_number("for [s]", 0.5, min=0.001, max=60.0, step=0.1)
            self._buttons(
                "",
                {
                    "Push": lambda: self._known.push(
                        robot.value, link.value, force.value, duration.value
                    )
                },
            )
        self._offered[PUSH] = [folder]

    def _plant(self) -> None:
        """Add what steers the plant."""
        with self._gui.add_folder("Plant", order=30) as self._plant_folder:
            for robot in self._known.robots:
                enable = partial(self._known.enable, robot)
                self._offered[f"{ENABLE} {robot}"] = [
                    self._buttons(
                        robot, {"Enable": partial(enable, True), "Disable": partial(enable, False)}
                    )
                ]
            self._offered[PLANT] = [
                self._buttons("", {"Pause": lambda: Pause(True), "Continue": lambda: Pause(False)}),
                self._buttons("", {"One tick": Step, "Reset": Reset}),
            ]

    def _sequences(self) -> None:
        """Add the sequences of tasks."""
        with self._gui.add_folder("Sequence", order=35) as folder:
            sequence = self._gui.add_dropdown("of tasks", tuple(self._known.sequences))
            self._buttons(
                "",
                {
                    "Execute": lambda: self._known.execute(sequence.value),
                    "Release": Release,
                    "Stop": Stop,
                },
            )
        self._offered[SEQUENCES] = [folder]

    def _buttons(
        self, label: str, orders: Mapping[str, Callable[[], Order]]
    ) -> viser.GuiButtonGroupHandle:
        """Add buttons, each of which asks for what its function returns, or says why it may not."""
        group = self._gui.add_button_group(label, tuple(orders))

        @group.on_click
        def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            try:
                self._ask(orders[one_of(event.target.value, "button", orders)]())
            except InputError as error:
                self._refuse(str(error))

        return group


def _floats(text: str, what: str) -> list[float]:
    """Return the numbers in a text; raises InputError."""
    try:
        return [float(word) for word in text.replace(",", " ").split()]
    except ValueError as error:
        raise InputError(f"{what}: {error}") from error
