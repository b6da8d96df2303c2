"""Parameters of the HTMPC: horizon, weights and constraints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lexstack.errors import ConfigurationError
from lexstack.options import not_negative, positive

Constraint = Literal["sum", "stage", "axis"]
"""How the levels below keep a level's result: H(11) as printed, per stage, or H(12)."""

_MOST_STAGES = 100


@dataclass(frozen=True, slots=True)
class TaskWeightsConfig:
    """Weights of H(8) and the tolerance of H(13), for one kind of task."""

    stage: float  # Q of the positions [1/m2]
    terminal: float  # P of the positions [1/m2]
    stage_angle: float  # Q of the angles [1/rad2]
    terminal_angle: float  # P of the angles [1/rad2]
    tolerance: float  # delta of the positions [m]
    tolerance_angle: float  # delta of the angles [rad]

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        not_negative(
            where,
            stage=self.stage,
            stage_angle=self.stage_angle,
            tolerance=self.tolerance,
            tolerance_angle=self.tolerance_angle,
        )
        positive(where, terminal=self.terminal, terminal_angle=self.terminal_angle)


@dataclass(frozen=True, slots=True)
class EffortConfig:
    """Weights of H(10), for the joints of base and arm."""

    base_velocity: float  # S_v [s2/m2, s2/rad2]
    arm_velocity: float  # S_v [s2/rad2]
    base_input: float  # R [s4/m2, s4/rad2]
    arm_input: float  # R [s4/rad2]
    base_change: float  # W [s4/m2, s4/rad2]
    arm_change: float  # W [s4/rad2]

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range: R makes the program convex."""
        positive(where, base_input=self.base_input, arm_input=self.arm_input)
        not_negative(
            where,
            base_velocity=self.base_velocity,
            arm_velocity=self.arm_velocity,
            base_change=self.base_change,
            arm_change=self.arm_change,
        )


@dataclass(frozen=True, slots=True)
class BarrierConfig:
    """A relaxed log barrier: -mu ln(z) for z > zeta, a parabola below."""

    mu: float  # its weight
    zeta: float  # m, rad, m/s ...: where the parabola begins

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        positive(where, mu=self.mu, zeta=self.zeta)


@dataclass(frozen=True, slots=True)
class CollisionConfig:
    """Distances that the spheres of the robot keep, H(7c)."""

    mu: float  # weight of the barrier
    zeta: float  # m, where its parabola begins
    margin: float  # m, delta_safe
    influence: float  # m, distances beyond it cost nothing; 0: all do, as in H
    ground: bool  # whether the arm keeps away from the floor too

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        positive(where, mu=self.mu, zeta=self.zeta)
        not_negative(where, margin=self.margin, influence=self.influence)
        if self.influence and self.influence <= self.margin + self.zeta:
            raise ConfigurationError(
                f"{where}: influence: must be beyond margin + zeta, got {self.influence}"
            )


@dataclass(frozen=True, slots=True)
class LineSearchConfig:
    """Backtracking: steps 1, beta, beta^2 ... until descent and H(13) hold."""

    descent: float  # of the cost that the slope promises, this part must come (Armijo)
    beta: float  # factor from trial to trial
    trials: int  # then no step

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        for name, value in (("descent", self.descent), ("beta", self.beta)):
            if not 0.0 < value < 1.0:
                raise ConfigurationError(f"{where}: {name}: must be in (0, 1), got {value}")
        if self.trials < 1:
            raise ConfigurationError(f"{where}: trials: must be at least 1, got {self.trials}")


@dataclass(frozen=True, slots=True)
class HtmpcConfig:
    """One set of parameters of the HTMPC, H(7) to H(13)."""

    name: str
    horizon: int  # N, stages
    step: float  # s, length of a stage
    iterations: int  # MAX_ITER of Algorithm 2, per level
    enough: float  # of the cost: the last iteration is one whose task gains less; 0: never enough
    lexicographic: Constraint  # H(11) as printed (sum), H(11) per stage, or H(12) (axis)
    correction: bool  # second-order correction: one more solve with the true errors of the step
    resume: bool  # a level below may begin at the plan before, where it costs less and H(13) holds
    hard_limits: bool  # limits of state and input as constraints too, not as barriers alone
    ee: TaskWeightsConfig
    base: TaskWeightsConfig
    effort: EffortConfig
    limits: BarrierConfig
    collision: CollisionConfig
    line_search: LineSearchConfig

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        if not 2 <= self.horizon <= _MOST_STAGES:
            raise ConfigurationError(
                f"{where}: horizon: must be in [2, {_MOST_STAGES}], got {self.horizon}"
            )
        positive(where, step=self.step)
        if self.correction and self.lexicographic != "axis":
            raise ConfigurationError(f"{where}: correction: needs lexicographic: axis")
        not_negative(where, enough=self.enough)
        if self.iterations < 1:
            raise ConfigurationError(
                f"{where}: iterations: must be at least 1, got {self.iterations}"
            )


DEFAULT_HTMPC = HtmpcConfig(
    name="lexstack",
    horizon=10,
    step=0.1,
    iterations=3,
    enough=0.03,
    lexicographic="axis",
    correction=True,
    resume=False,
    hard_limits=True,
    ee=TaskWeightsConfig(640.0, 6400.0, 100.0, 1000.0, 0.01, 0.01),
    base=TaskWeightsConfig(54.0, 540.0, 100.0, 1000.0, 0.01, 0.01),
    effort=EffortConfig(0.027, 0.027, 0.06, 0.051, 0.007, 0.0),
    limits=BarrierConfig(0.001, 0.005),
    collision=CollisionConfig(0.1, 0.005, 0.05, 0.3, ground=True),
    line_search=LineSearchConfig(0.05, 0.5, 10),
)
"""The parameters of ``config/htmpc/lexstack.yaml``, where every one has its reason."""
