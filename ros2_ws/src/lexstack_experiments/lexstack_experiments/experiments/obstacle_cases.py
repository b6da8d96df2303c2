"""What stands and moves in the robots' way, and what is done about it."""

from __future__ import annotations

from dataclasses import dataclass, field

from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig, PoseConfig
from lexstack_experiments.runs import changed

NOTHING, BASE, DISTANCE = "nothing", "base task", "distance task"
"""Ways: no avoidance; T, Sec. III-B c; and the inequality task at the highest level."""

_ROUND = (1.0, 0.0, 0.0, 0.0)  # tools point down, as where they start
_IN_TIME = 2.0  # s: the base task must be told before the ball comes
_PASSING = 6.5  # s: the ball that rolls is beside robot A's platform
_ASIDE = {"robot_a": (0.0, -0.3, 0.0), "robot_b": (2.0, -0.3, 0.0)}  # out of its way
_BACK = {"robot_a": (-0.2, 0.0, 0.0), "robot_b": (2.0, 0.0, 0.0)}


@dataclass(frozen=True, slots=True)
class Variant:
    """One way through a case: the stack at first, and what happens then."""

    stack: str
    events: tuple[EventConfig, ...] = ()


@dataclass(frozen=True, slots=True)
class Case:
    """One thing in the way.

    Attributes:
        name: as in the tables.
        obstacles: of the scenario ``obstacle``, by name.
        duration: s.
        variants: by name; the first one does nothing about it.
        holds: whether the tools are asked to stay where they are, all the time.
        meet: whether the robots are in each other's way.
    """

    name: str
    obstacles: tuple[str, ...]
    duration: float
    variants: dict[str, Variant] = field(default_factory=dict)
    holds: bool = True
    meet: bool = False

    def scenario(self, whole: ResolvedScenario, variant: str, seed: int) -> ResolvedScenario:
        """Return the scenario ``obstacle`` with what this case has of it."""
        chosen = self.variants[variant]
        obstacles = {name: whole.scenario.obstacles[name] for name in self.obstacles}
        return changed(
            whole,
            initial_stack=chosen.stack,
            events=chosen.events,
            obstacles=obstacles,
            duration=self.duration,
            seed=seed,
        )


def cases() -> tuple[Case, ...]:
    """Return all cases, in the order of the table."""
    past = EventConfig(0.5, ee_target={"robot_a": PoseConfig((0.307, 1.0, 0.938), _ROUND)})
    across = EventConfig(
        0.5,
        ee_target={
            "robot_a": PoseConfig((1.3, 0.0, 0.938), _ROUND),
            "robot_b": PoseConfig((1.0, 0.0, 0.938), _ROUND),
        },
    )
    aside = EventConfig(_IN_TIME, switch="reach_base", base_target=_ASIDE)
    return (
        Case(
            "rolling past",
            ("rolling",),
            16.0,
            {NOTHING: Variant("track"), BASE: Variant("track", (aside,)),
             DISTANCE: Variant("avoid")},
        ),
        Case(
            "switch while it passes",
            ("rolling",),
            16.0,
            {NOTHING: Variant("track", (_switch("reach_base"),)),
             DISTANCE: Variant("avoid", (_switch("avoid_base"),))},
        ),
        Case(
            "flying past",
            ("flying",),
            21.0,
            {NOTHING: Variant("track"), DISTANCE: Variant("avoid")},
        ),
        Case(
            "hanging in the way",
            ("hanging",),
            8.0,
            {NOTHING: Variant("track", (past,)), DISTANCE: Variant("avoid", (past,))},
            holds=False,
        ),
        Case(
            "robots sent across",
            (),
            8.0,
            {NOTHING: Variant("track", (across,)), DISTANCE: Variant("keep_apart", (across,))},
            holds=False,
            meet=True,
        ),
    )  # fmt: skip


def _switch(stack: str) -> EventConfig:
    """Return the switch in the middle of the ball's way past robot A."""
    return EventConfig(_PASSING, switch=stack, base_target=_BACK)
