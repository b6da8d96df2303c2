"""One level of the HTMPC by different solvers: the same problem, states and guesses.

The tool goes to goals around it, one new goal every four seconds; the problem is level 1 of the
authors: tracking, effort with changes, barriers. States come from a closed loop of ours, and every
solver begins from the shifted plan of that loop. Costs are compared with the optimum by IPOPT.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from time import thread_time
from typing import Any

import numpy as np
import pinocchio

from lexstack.errors import LexstackError
from lexstack.mpc import Htmpc, HtmpcConfig, Objective, Plan, Start
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_config.resolved import load_htmpc, load_robot
from lexstack_experiments.baselines.htmpc_hpipm import HpipmHtmpc
from lexstack_experiments.baselines.htmpc_oracle import HtmpcOracle
from lexstack_experiments.baselines.htmpc_paper import PaperHtmpc
from lexstack_experiments.benches.child import Child
from lexstack_experiments.benches.peers import MISSING, child_with
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.measuring import no_collection, silent
from lexstack_experiments.results import Cell, Figure, Results, Table, zero

NAME = "htmpc-peers"
STATES = 30
ROBOTS = ("ur10_ridgeback", "panda_summit")
HORIZONS = (10, 20, 30)
PEERS = {"crocoddyl": "crocoddyl, FDDP", "acados": "acados"}
KIND = "ee_position"
_OURS = "lexstack"
_GOAL_TIME = 4.0  # s
_MOST = 10  # iterations of a solve to convergence
_MS = 1e3

_COLUMNS = ("robot", "N", "solver", "iterations", "p50 over ours", "gap, mean",
            "gap, worst", "cpu ms p50", "cpu ms p99", "failed")  # fmt: skip

NOTES = (
    "gap: the cost over IPOPT's optimum, mean and worst of the states, as a share of",
    "what braking costs over it, mean of the states; cpu ms: time of the thread.",
    "lexstack, the paper's way and HPIPM take one Gauss-Newton step from the same guess, then the",
    "same line search. HPIPM: CasADi's functions evaluate, its QP object is made once; QP alone:",
    "the call of the object. crocoddyl: FDDP, costs as action models in Python; solver alone:",
    "without these. acados: generated and compiled C, RTI (full steps) and SQP; solver alone: its",
    "own clock, the wall's, without the calls from Python that set and get. A negative gap is a",
    "better local minimum than IPOPT's.",
)


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """What a solve is given."""

    start: Start
    before: Plan
    objective: Objective
    guess: Matrix  # inputs, (N, n)
    last: Vector  # the input before, (n,)

    @property
    def triple(self) -> tuple[Vector, Vector, Vector]:
        """q, v and the input before."""
        return self.start.q, self.start.v, self.last


@dataclass(slots=True)
class Answers:
    """What a solver made of the states: inputs, times [s], and how many it failed."""

    inputs: list[Matrix] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    failed: int = 0


class Case:
    """One robot and horizon: the states, and what everybody is measured by."""

    def __init__(self, name: str, horizon: int, options: Options, count: int) -> None:
        """Run the closed loop and solve every state by IPOPT."""
        self.name, self.horizon = name, horizon
        self.robot = RobotModel("robot", load_robot(options.config / "robots" / f"{name}.yaml"))
        loaded = load_htmpc(options.config / "htmpc" / "authors.yaml")
        self.config: HtmpcConfig = dataclasses.replace(loaded, horizon=horizon)
        self.paper = PaperHtmpc(self.robot, self.config, (KIND,), "osqp")
        self.states = _states(self.robot, self.config, options.seed, count)
        oracle = HtmpcOracle(self.robot, self.config, (KIND,))
        optima = []
        with silent():
            for state in self.states:
                level = oracle.solve(state.triple, (state.objective,), state.guess)[0]
                optima.append(level.total if level.converged else np.nan)
        self.optima = np.array(optima)
        most = self.robot.limits.acceleration
        stops = [braking(state.start.v, most, self.config) for state in self.states]
        self._scale = float(np.nanmean(self._costs(stops) - self.optima))

    def line(
        self, solver: str, iterations: str, found: Answers, ours: float, costs: bool = True
    ) -> tuple[Cell, ...]:
        """Return a row of the table; ``ours`` is our p50 [s]."""
        p50, p99 = np.percentile(found.times, (50.0, 99.0))
        gaps: tuple[Cell, Cell] = (None, None)
        if costs:
            above = (self._costs(found.inputs) - self.optima) / self._scale
            gaps = f"{np.nanmean(above):.1e}", f"{np.nanmax(above):.1e}"
        who = (self.name, self.horizon, solver, iterations)
        return *who, float(p50) / ours, *gaps, _MS * float(p50), _MS * float(p99), found.failed

    def _costs(self, inputs: list[Matrix]) -> Vector:
        """Return what inputs cost at the states, by the functions of the paper's way, (m,)."""
        pairs = zip(self.states, inputs, strict=True)
        return np.array([self.paper.cost(s.triple, (s.objective,), u) for s, u in pairs])


def braking(v: Vector, acceleration: Vector, config: HtmpcConfig) -> Matrix:
    """Return the inputs (N, n) that stop every joint as soon as its limit lets it."""
    inputs = np.empty((config.horizon, v.size))
    for k in range(config.horizon):
        inputs[k] = np.clip(-v / config.step, -acceleration, acceleration)
        v = v + config.step * inputs[k]
    return inputs


def _states(robot: RobotModel, config: HtmpcConfig, seed: int, count: int) -> list[State]:
    """Return states of a closed loop of ours."""
    rng = np.random.default_rng(seed)
    optimiser = Htmpc(robot, config)
    q, v = robot.home((0.0, 0.0, 0.0)), np.zeros(robot.n)
    tool = robot.tool(q)[0].position
    goals = tool + rng.uniform((-1.0, -1.0, -0.3), (1.0, 1.0, 0.3), (64, 3))
    plan: Plan | None = None
    found: list[State] = []
    while len(found) < count:
        now = (len(found) + (plan is not None)) * config.step
        times = now + optimiser.horizon.times[1:]
        which = (times / _GOAL_TIME).astype(int) % len(goals)
        objective = Objective("0/tool", KIND, goals[which])
        start = Start(now, q, v)
        if plan is not None:
            guess, last = plan.shifted(now), plan.input_before(now)
            found.append(State(start, plan, objective, guess, last))
        plan = optimiser.solve(start, (objective,), plan)
        q, v = plan.q[1], plan.v[1]
    return found


def run(options: Options) -> Results:
    """Measure everybody who is here on all robots and horizons."""
    lines: list[tuple[Cell, ...]] = []
    with ExitStack() as stack:
        children, missing = _children(options, stack)
        for name in ROBOTS:
            for horizon in HORIZONS:
                case = Case(name, horizon, options, options.cases)
                with silent(), no_collection():
                    lines += _lines(case, children)
                options.say(f"{name}, N = {horizon}")
    table = Table(_COLUMNS, lines, "one level, the same problem for all")
    return options.results(
        NAME, _figures(table), table, {"level": KIND, "parameters": "authors"}, (*NOTES, *missing)
    )


def _children(options: Options, stack: ExitStack) -> tuple[dict[str, Child], list[str]]:
    """Return the peers of other Pythons by their names, and a line for each who is not here."""
    missing, here = list[str](), dict[str, Child]()
    for module, name in PEERS.items():
        child = child_with(module, f"mpc_{module}", options.peers)
        if child is None:
            missing.append(MISSING[module])
        else:
            here[name] = stack.enter_context(child)
    return here, missing


def _figures(table: Table) -> list[Figure]:
    """Return how long the others take beside ours, with one step, and what a step leaves."""
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.rows]
    figures = []
    for row in rows:
        where = f"{row['robot']}, N = {row['N']}"
        if row["iterations"] == "1" and row["solver"] != _OURS and row["gap, mean"] is not None:
            name = f"{where}: one step of {row['solver']} over one of ours, p50"
            figures.append(Figure(name, float(row["p50 over ours"])))
        if row["solver"] == _OURS:
            figures.append(
                Figure(f"{where}: one step of ours, p50", float(row["cpu ms p50"]), "ms")
            )
    failed = sum(int(row["failed"]) for row in rows if row["solver"] == _OURS)
    return [*figures, zero("Failed solves of ours", float(failed))]


def _lines(case: Case, children: dict[str, Child]) -> list[tuple[Cell, ...]]:
    """Return the rows of one robot and horizon."""
    more = dataclasses.replace(case.config, iterations=_MOST, early_stop_ratio=1e-6)
    hpipm = HpipmHtmpc(case.robot, case.config, KIND)
    solvers: dict[str, Callable[[State], tuple[Matrix, bool]]] = {
        _OURS: _ours(case.robot, case.config),
        "lexstack, to the end": _ours(case.robot, more),
        "the paper's way, OSQP": _theirs(case.paper),
        "HPIPM through CasADi": _theirs(hpipm),
    }
    answers = _in_turns(case.states, solvers)
    ours = float(np.median(answers[_OURS].times))
    last = {"lexstack, to the end": f"up to {_MOST}"}
    lines = [case.line(name, last.get(name, "1"), found, ours) for name, found in answers.items()]
    # One more pass tells what of it is the QP alone.
    alone = Answers(times=_alone(case.states, hpipm))
    lines.append(case.line("HPIPM, QP alone", "1", alone, ours, costs=False))
    for name, child in children.items():
        try:
            lines += _of_child(case, name, child, ours)
        except LexstackError as error:  # said in its row: the others' are worth having
            nothing = (None,) * (len(_COLUMNS) - 4)
            lines.append((case.name, case.horizon, name, f"not measured: {error}", *nothing))
    return lines


def _ours(robot: RobotModel, config: HtmpcConfig) -> Callable[[State], tuple[Matrix, bool]]:
    """Return our solver as a function of a state."""
    optimiser = Htmpc(robot, config)

    def solve(state: State) -> tuple[Matrix, bool]:
        plan = optimiser.solve(state.start, (state.objective,), state.before)
        return plan.u, plan.solved

    return solve


def _theirs(solver: PaperHtmpc) -> Callable[[State], tuple[Matrix, bool]]:
    """Return a solver with CasADi's functions as a function of a state."""

    def solve(state: State) -> tuple[Matrix, bool]:
        before = solver.failures
        u, _ = solver.solve(state.triple, (state.objective,), state.guess)
        return u, solver.failures == before

    return solve


def _in_turns(
    states: list[State], solvers: dict[str, Callable[[State], tuple[Matrix, bool]]]
) -> dict[str, Answers]:
    """Return what all solvers make of all states, state by state, after one to warm up."""
    for solve in solvers.values():
        solve(states[0])
    found = {name: Answers() for name in solvers}
    for state in states:
        for name, solve in solvers.items():
            begun = thread_time()
            u, solved = solve(state)
            found[name].times.append(thread_time() - begun)
            found[name].inputs.append(u)
            found[name].failed += not solved
    return found


def _alone(states: list[State], solver: HpipmHtmpc) -> list[float]:
    """Return the time in HPIPM of every state [s]."""
    times = []
    for state in states:
        before = solver.qp_seconds
        solver.solve(state.triple, (state.objective,), state.guess)
        times.append(solver.qp_seconds - before)
    return times


def _of_child(case: Case, name: str, child: Child, ours: float) -> list[tuple[Cell, ...]]:
    """Return the rows of a peer in another Python: one iteration, and to convergence."""
    key = f"{case.name}, {case.horizon}"
    child.ask("load", name=key, **_written(case))
    lines = []
    for most in (1, 100):
        child.ask("solve", name=key, iterations=most)  # warms up
        told = child.ask("solve", name=key, iterations=most)
        inputs = [np.array(u) for u in told["u"]]
        found = Answers(inputs, told["times"], sum(told["failed"]))
        often = "1" if most == 1 else f"{np.median(told['iterations']):.0f} (median)"
        lines.append(case.line(name, often, found, ours))
        some = Answers(times=told["alone"])
        lines.append(case.line(f"{name}, solver alone", often, some, ours, costs=False))
    return lines


def _written(case: Case) -> dict[str, Any]:
    """Return model, numbers and states as the worker takes them."""
    robot, config, limits = case.robot, case.config, case.robot.limits
    model, first = robot.pinocchio, robot.arm.start
    frame = model.frames[robot.frame("tool")]

    def by_joint(base: float, arm: float) -> list[float]:
        return [base] * first + [arm] * (robot.n - first)

    effort = config.effort
    numbers = {
        "dt": config.step,
        "mu": config.limits.mu,
        "zeta": config.limits.zeta,
        "velocity": by_joint(effort.base_velocity, effort.arm_velocity),
        "input": by_joint(effort.base_input, effort.arm_input),
        "change": by_joint(effort.base_change, effort.arm_change),
        "lower": limits.position_lower,
        "upper": limits.position_upper,
        "velocities": limits.velocity,
        "accelerations": limits.acceleration,
        "joint": int(frame.parentJoint),
        "offset": frame.placement.translation,
        "joints": _chain(model),
        "weights": [config.ee.stage, config.ee.terminal],
    }
    states = [
        {
            "q": state.start.q,
            "v": state.start.v,
            "before": state.last,
            "reference": state.objective.reference,
            "guess": state.guess,
        }
        for state in case.states
    ]
    return {"model": model.saveToString(), "numbers": numbers, "states": states}


def _chain(model: pinocchio.Model) -> list[dict[str, Any]]:
    """Return the joints of a chain: place in the one before, axis, and whether it slides."""
    data = model.createData()
    columns = pinocchio.computeJointJacobians(model, data, pinocchio.neutral(model))
    joints = []
    for k, place in enumerate(model.jointPlacements[1:]):
        turn = data.oMi[k + 1].rotation.T
        slides = not columns[3:, k].any()
        axis = turn @ (columns[:3, k] if slides else columns[3:, k])
        joints.append(
            {
                "position": place.translation,
                "rotation": place.rotation,
                "axis": axis,
                "slides": slides,
            }
        )
    return joints


EXPERIMENT = Experiment(
    "one level of the MPC by HPIPM, crocoddyl, acados and ours",
    "states per row",
    STATES,
    run,
    peers=tuple(PEERS),
)
