"""A whole system in one process, as a program starts it: robots, a stack, and time that goes on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from lexstack.control import lockstep
from lexstack.control.controller import Command
from lexstack.control.factory import make_controller, make_stack_solver
from lexstack.control.record import Record
from lexstack.control.run_plans import RunPlans
from lexstack.control.run_targets import RunTargets
from lexstack.errors import InputError
from lexstack.mpc import DEFAULT_HTMPC, HT_ARCH, Architecture, HtmpcConfig, Progress, SequenceTask
from lexstack.references import References, Target
from lexstack.robots import Configuration, ObstacleConfig, Obstacles, Robot, Team
from lexstack.tasks import JointLimitConfig
from lexstack.tasks.specs.compiled import Names, compiled
from lexstack.tasks.specs.stack import Stack, with_limits
from lexstack.tasks.stack import Stack as TeamStack
from lexstack.transition import TransitionConfig, TransitionOptions
from lexstack.types import RobotState, Vector


class Lockstep(lockstep.Lockstep):
    """The controller ("A"), the solver of the next stack ("B"), the MPC and a plant, in lockstep.

    Attributes:
        team: the robots.
        stack: that was asked for last.
        progress: of the sequence that each robot works on, by its name.
    """

    def __init__(
        self,
        robots: Robot | Sequence[Robot],
        stack: Stack,
        dt: float,
        *,
        q: object = None,
        plant: Callable[[Team, Vector], lockstep.Plant] | None = None,
        obstacles: Mapping[str, ObstacleConfig] | None = None,
        lead_in: float = 0.5,
        limit_jerk: bool = False,
    ) -> None:
        """Start on a stack, at rest.

        Args:
            robots: one or several; tasks with ``robot="name"`` are about one of them.
            stack: the first one.
            dt: control period [s].
            q: where the robots start, one after the other, shape (n_q,); None: at home.
            plant: makes what is moved of the robots and their start, such as ``mujoco_plant`` of
                ``lexstack_sim``; None: ``ExactPlant``, which follows every command at once.
            obstacles: that ``CollisionAvoidance`` keeps away from, by name.
            lead_in: time in which a reference moves to a new target [s]; 0: it steps.
            limit_jerk: whether jerk is limited at every tick.

        Raises:
            ConfigurationError: the stack does not fit the robots; the text names the task.
            InputError: a number is out of range.
        """
        if not 0.0 < dt < np.inf:
            raise InputError(f"dt: must be finite and > 0, got {dt}")
        several = (robots,) if isinstance(robots, Robot) else tuple(robots)
        team = Team(tuple(r.model for r in several), dt, Obstacles(obstacles or {}))
        start = Configuration.of(team, team.home() if q is None else q).q
        self.team = team
        self._names = Names()
        self._stacks: dict[str, TeamStack] = {}
        self._kept: list[Stack] = []  # in the order of their numbers
        self._limits: dict[str, dict[str, JointLimitConfig]] = {}
        self._limited: list[tuple[Stack, dict[str, dict[str, JointLimitConfig]], Stack]] = []
        self._states: list[RobotState] = []
        self._commands: list[Command] = []
        self.stack = stack
        self._targets = RunTargets(team)
        first = self._known(stack)
        self._asked = {first}  # the controller knows them
        switch = TransitionConfig(duration=1.0)
        options = TransitionOptions(first, switch, limit_jerk=limit_jerk)
        controller = make_controller(team, self._stacks, options)
        controller.references.lead_in = lead_in
        super().__init__(
            team,
            controller,
            make_stack_solver(team, self._stacks),
            plant(team, start) if plant else lockstep.ExactPlant(start, dt, team),
        )
        self._plans = RunPlans(team, options.plan_every)
        self.plans = self._plans.at
        self._targets.use(first, 0)

    # ---- what goes on

    @property
    def state(self) -> RobotState:
        """The present state of all robots."""
        return self.plant.state()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.state.stamp

    @property
    def configuration(self) -> Configuration:
        """Where the robots are: poses and Jacobians of frames by name."""
        return Configuration(self.team, self.kinematics(self.state))

    @property
    def progress(self) -> dict[str, Progress]:
        """How far the sequence of each robot is, by its name; after a sequence has begun."""
        return self._plans.progress

    def step(self) -> Command:
        """Serve one tick: targets, plans, the solver's answers, the command, the plant's step."""
        self.controller.begin(self.state)
        self._targets.give(self.controller.references, self.state, self.kinematics)
        return super().step()

    def until(self, time: float) -> Command:
        """Serve ticks up to a simulated time [s], at least one; return the last command."""
        command = self.step()
        while self.time < time - 0.5 * self.team.dt:
            command = self.step()
        return command

    def served(self, state: RobotState, references: References, command: Command) -> None:
        """Keep what a tick was."""
        self._states.append(state)
        self._commands.append(command)

    def record(self) -> Record:
        """Return all ticks until now as arrays, to be plotted."""
        return Record.of(self.team, self._states, self._commands)

    # ---- what is asked for

    def switch(
        self,
        stack: Stack,
        duration: float = 1.0,
        *,
        at: float | None = None,
        method: str = "",
        robots: Sequence[str] = (),
    ) -> int:
        """Go smoothly to another stack; return the number of the transition.

        Args:
            stack: the one to come; tasks that it shares with the present one keep their targets.
            duration: of the blend [s].
            at: when it begins, in simulated time [s]; None: now.
            method: of the transition, a key of ``METHODS``; empty: ``bridge``.
            robots: names of those that shall go there; empty: all.

        Raises:
            ConfigurationError: the stack does not fit the robots; the text names the task.
            InputError: the request is refused; the text says why.
        """
        return self._switch(
            self._known(self._with_limits(stack)), stack, duration, at, method, robots
        )

    def limits(
        self,
        joints: Iterable[str] = (),
        *,
        robot: str = "",
        position: tuple[float, float] | None = None,
        velocity: float | None = None,
        acceleration: float | None = None,
        jerk: float | None = None,
        duration: float = 1.0,
    ) -> int:
        """Tighten limits of joints, for the present stack and all later ones; return a transition.

        The joints come within the new limits as fast as the old ones allow, and stay inside. Where
        a stack has limits too, the tighter ones hold. Without any limit the robots' own are back.

        Args:
            joints: their names; empty: all joints of the robot.
            robot: its name; empty: every robot.
            position: lower and upper end [rad, m]; None, as below: the limit stays as it was.
            velocity: rad/s, m/s.
            acceleration: rad/s2, m/s2.
            jerk: rad/s3, m/s3.
            duration: of the blend [s].

        Raises:
            ConfigurationError: a limit is out of range, or wider than the robot's own.
        """
        given = {"position": position, "velocity": velocity, "acceleration": acceleration}
        given |= {"jerk": jerk}
        tighter = {key: value for key, value in given.items() if value is not None}
        chosen = [self.team.robots[self.team.index(robot)]] if robot else self.team.robots
        limits = {r.name: dict.fromkeys(tuple(joints) or r.joints, tighter) for r in chosen}
        self._limits = with_limits(self._limits, limits) if tighter else {}
        return self.switch(self.stack, duration)

    def add_target(self, target: Target) -> None:
        """Give a reference by itself, for tasks that read references: see ``Target``."""
        self.controller.references.add(target)

    def sequence(
        self,
        tasks: Sequence[SequenceTask],
        *,
        robot: str = "",
        architecture: Architecture = HT_ARCH,
        config: HtmpcConfig = DEFAULT_HTMPC,
        duration: float = 1.0,
    ) -> int:
        """Go smoothly to the plans of the MPC for a sequence of tasks; return a transition.

        The present stack stands in where a plan is late. ``progress`` says how far it is; to end
        it, switch to a stack.

        Args:
            tasks: done one after the other, two at a time in a strict order.
            robot: its name; empty: the only one.
            architecture: ``HT_ARCH``, or ``ST_ARCH`` for one task at a time.
            config: parameters of the MPC.
            duration: of the blend into the plan [s].

        Raises:
            InputError: a task does not fit the robot, or there are several and none is named.
        """
        if not robot and len(self.team.names) > 1:
            raise InputError(f"sequence: of which robot? {', '.join(self.team.names)}")
        place = self.team.index(robot) if robot else 0
        self._plans.begin(place, tuple(tasks), architecture, config, self.state, duration)
        known = self._stacks[self._known(self._with_limits(self.stack))]
        robots = (place,)
        planned = known.of(robots)
        name = f"plan of {self.team.names[place]} over {known.name}"
        self._stacks[name] = TeamStack(name, planned.levels, planned.limits, robots, planned=True)
        return self._switch(name, self.stack, duration, None, "", ())

    # ---- inside

    def _switch(
        self,
        name: str,
        stack: Stack,
        duration: float,
        at: float | None,
        method: str,
        robots: Sequence[str],
    ) -> int:
        """Ask for a known stack; raises InputError where that is refused."""
        tick = 0 if at is None else max(round(at / self.team.dt), self.state.tick)
        transition = self.controller.transition
        how = (duration, method, tick, robots)
        if name in self._asked:
            answer = transition.ask(name, *how)
        else:
            self.solver.learn(self._stacks[name])
            answer = transition.ask_new(self._stacks[name], *how)
        if answer.request is None:
            raise InputError(f"switch: {answer.message}")
        self._asked.add(name)
        self.stack = stack
        self._targets.use(name, answer.request.at_tick)
        return answer.request.id

    def _with_limits(self, stack: Stack) -> Stack:
        """Return a stack within the limits that were asked of the run; the same for the same."""
        if not self._limits:
            return stack
        for known, limits, limited in self._limited:
            if known is stack and limits == self._limits:
                return limited
        merged = with_limits(stack.limits, self._limits, tightest=True)
        limited = replace(stack, limits=merged, name=stack.name)
        self._limited.append((stack, self._limits, limited))
        return limited

    def _known(self, stack: Stack) -> str:
        """Return the name under which the controller knows a stack, and let it know new ones."""
        for number, known in enumerate(self._kept, 1):
            if known is stack:
                return _called(stack, number)
        number = len(self._kept) + 1
        name = _called(stack, number)
        made = compiled(stack, self.team, self._names, name)
        self._kept.append(stack)
        self._stacks[name] = made.stack
        self._targets.know(name, made.aims)
        return name


def _called(stack: Stack, number: int) -> str:
    """Return a stack's name, which no other one of the run has."""
    return (
        f"{stack.name}#{number}" if stack.name and number > 1 else stack.name or f"stack {number}"
    )
