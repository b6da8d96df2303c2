"""Parameters of the HTMPC: horizon, weights and constraints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lexstack.errors import ConfigurationError
from lexstack.options import NotNegative, Positive, Range

Evaluation = Literal["compiled", "plain"]
"""How costs and their derivatives are computed: by the compiled code, or by numpy and CasADi."""

QpMethod = Literal["structured", "condensed"]
"""How the QP of an SQP iteration is solved: by its structure, or condensed to the inputs."""

Constraint = Literal["sum", "stage", "axis"]
"""How the levels below keep a level's result: H(11) as printed, per stage, or H(12)."""

_MOST_STAGES = 100
_Fraction = Annotated[float, Range(0.0, 1.0, open=True)]


@dataclass(frozen=True, slots=True)
class TaskWeightsConfig:
    """Weights of H(8) and the tolerance of H(13), for one kind of task."""

    stage: NotNegative  # Q of the positions [1/m2]
    terminal: Positive  # P of the positions [1/m2]
    stage_angle: NotNegative  # Q of the angles [1/rad2]
    terminal_angle: Positive  # P of the angles [1/rad2]
    tolerance: NotNegative  # delta of the positions [m]
    tolerance_angle: NotNegative  # delta of the angles [rad]


@dataclass(frozen=True, slots=True)
class EffortConfig:
    """Weights of H(10), for the joints of base and arm."""

    base_velocity: NotNegative  # S_v [s2/m2, s2/rad2]
    arm_velocity: NotNegative  # S_v [s2/rad2]
    base_input: Positive  # R [s4/m2, s4/rad2]: > 0, so that the program is convex
    arm_input: Positive  # R [s4/rad2]: > 0, so that the program is convex
    base_change: NotNegative  # W [s4/m2, s4/rad2]
    arm_change: NotNegative  # W [s4/rad2]


@dataclass(frozen=True, slots=True)
class BarrierConfig:
    """A relaxed log barrier: -mu ln(z) for z > zeta, a parabola below."""

    mu: Positive  # its weight
    zeta: Positive  # m, rad, m/s ...: where the parabola begins


@dataclass(frozen=True, slots=True)
class CollisionConfig:
    """Distances that the spheres of the robot keep, H(7c)."""

    mu: Positive  # weight of the barrier
    zeta: Positive  # m, where its parabola begins
    margin: NotNegative  # m, delta_safe
    influence: NotNegative  # m, distances beyond it cost nothing; 0: all do, as in H
    ground: bool  # whether the arm keeps away from the floor too

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for an influence that no distance is within."""
        if self.influence and self.influence <= self.margin + self.zeta:
            raise ConfigurationError(
                f"{where}: influence: must be beyond margin + zeta, got {self.influence}"
            )


@dataclass(frozen=True, slots=True)
class LineSearchConfig:
    """Backtracking: steps 1, beta, beta^2 ... until descent and H(13) hold."""

    descent: _Fraction  # of the cost that the slope promises, this part must come (Armijo)
    beta: _Fraction  # factor from trial to trial
    trials: Annotated[int, Range(1)]  # then no step


@dataclass(frozen=True, slots=True)
class HtmpcConfig:
    """One set of parameters of the HTMPC, H(7) to H(13)."""

    name: str  # of its file
    horizon: Annotated[int, Range(2, _MOST_STAGES)]  # N, stages
    step: Positive  # s, length of a stage
    iterations: Annotated[int, Range(1)]  # MAX_ITER of Algorithm 2, per level
    # of the cost: an iteration whose task gains less is the last one; 0: none is
    early_stop_ratio: NotNegative
    lexicographic: Constraint  # H(11) as printed (sum), H(11) per stage, or H(12) (axis)
    second_order_correction: bool  # one more solve with the true errors of the step
    # a level below may begin at the previous plan, where that costs less and H(13) holds
    restart_from_previous: bool
    hard_limits: bool  # limits of state and input as constraints too, not as barriers alone
    ee: TaskWeightsConfig  # weights of tasks of the tool
    base: TaskWeightsConfig  # weights of tasks of the platform
    effort: EffortConfig  # weights of velocity, input and its changes
    limits: BarrierConfig  # barrier before the limits of the joints
    collision: CollisionConfig  # distances to obstacles
    line_search: LineSearchConfig  # how a step is shortened
    # weights of tasks of joints: of those that slide as positions, of those that turn as angles
    joint: TaskWeightsConfig = TaskWeightsConfig(54.0, 540.0, 100.0, 1000.0, 0.01, 0.01)
    # of costs and their derivatives: by compiled code, or by numpy; the same but for rounding
    evaluation: Evaluation = "compiled"
    # whether the other robots are avoided where their plans, or else their velocities, will take
    # them; false: where they stand
    predict_others: bool = False
    # how a QP is solved; a file without this key, and a bag recorded before it, means "condensed"
    qp: QpMethod = "condensed"
    # s of wall time for a solve, after which no iteration is begun but the first one; 0: no end.
    # With it plans depend on the machine, so runs in lockstep have none
    deadline: NotNegative = 0.0

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a correction of what has none."""
        if self.second_order_correction and self.lexicographic != "axis":
            raise ConfigurationError(f"{where}: second_order_correction: needs lexicographic: axis")


DEFAULT_HTMPC = HtmpcConfig(
    name="lexstack",
    horizon=10,
    step=0.1,
    iterations=3,
    early_stop_ratio=0.03,
    lexicographic="axis",
    second_order_correction=True,
    restart_from_previous=False,
    hard_limits=True,
    ee=TaskWeightsConfig(640.0, 6400.0, 100.0, 1000.0, 0.01, 0.01),
    base=TaskWeightsConfig(54.0, 540.0, 100.0, 1000.0, 0.01, 0.01),
    effort=EffortConfig(0.027, 0.027, 0.06, 0.051, 0.007, 0.0),
    limits=BarrierConfig(0.001, 0.005),
    collision=CollisionConfig(0.1, 0.005, 0.05, 0.3, ground=True),
    line_search=LineSearchConfig(0.05, 0.5, 10),
    predict_others=True,
    qp="structured",
)
"""The parameters of ``config/htmpc/lexstack.yaml``, where every one has its reason."""
