"""The controller's transitions from stack to stack: which robots go where, and what comes next."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from lexstack.errors import ConfigurationError
from lexstack.limits.joint_limits import JointLimits
from lexstack.options import unknown
from lexstack.robots import Team
from lexstack.tasks.stack import AT_REST, Stack
from lexstack.transition.channel_problem import Plans
from lexstack.transition.channels.channel import Channel, source_of
from lexstack.transition.channels.gathering import begin, together
from lexstack.transition.channels.lineup import as_requested, cancelled, coupling, some_of
from lexstack.transition.due import Due
from lexstack.transition.messages import Announcement, SourceSample, TransitionState
from lexstack.transition.methods import METHODS
from lexstack.transition.options import TransitionOptions
from lexstack.transition.requested_limits import RequestedLimits, of_tick
from lexstack.transition.requests import Answer, RequestBook, SwitchRequest
from lexstack.transition.robot_group import RobotGroups
from lexstack.transition.sources.announcements import Announcer, wanted_of
from lexstack.transition.sources.inbox import Choice, LocalSource, Sources
from lexstack.transition.sources.mpc_plans import HeardPlan, MpcPlans
from lexstack.transition.sources.partial_samples import PartialSampleMerger
from lexstack.transition.status_report import coming, transition_state
from lexstack.transition.tick_context import TickContext
from lexstack.types import Vector


class Transition:
    """The transitions of one controller; ``step`` before its solve, ``finish`` after it.

    Robots that switch together, or that share a stack, make a channel. A request moves its robots
    into a channel of their own; the channels of the other robots continue unchanged. So several
    requests for different robots can be under way at the same time.
    """

    def __init__(
        self,
        stacks: Mapping[str, Stack],
        local: LocalSource,
        options: TransitionOptions,
        team: Team,
        unfit: Mapping[str, str] | None = None,
    ) -> None:
        """Start idle on the initial stack.

        Args:
            stacks: every stack that may be asked for, by name.
            local: what the controller follows where the stack solver is lost.
            options: where to start, how to go, and when a source counts as lost.
            team: the robots.
            unfit: why other stacks cannot be asked for, by name.

        Raises:
            ConfigurationError: nobody knows the method of ``options``.
        """
        if options.switch.method not in METHODS:
            raise ConfigurationError(unknown("method", options.switch.method, METHODS))
        everyone = tuple(range(len(team.robots)))
        whose = {
            name: everyone if stack.robots is None else stack.robots
            for name, stack in stacks.items()
        }
        self._stacks = dict(stacks)
        self._team = team
        self._whose = whose
        self._merger = PartialSampleMerger(team)
        self._sources = Sources(local, options)
        self._plans = MpcPlans(team, options)
        self._book = RequestBook(whose, METHODS, options.switch, unfit, horizon=options.horizon)
        self._adopts = options.switch.at_end == "adopt"
        self._lockstep = options.lockstep
        self._requested_limits = RequestedLimits(team.limits, always=options.limit_jerk)
        self._announcer = Announcer()
        self._tick = 0
        self._group = RobotGroups(team)
        initial = stacks[options.initial].of(everyone)
        first = Channel(self._group(everyone), (initial,), initial.name)
        self._channels: tuple[Channel, ...] = (first,)

    @property
    def stack(self) -> str:
        """Names of the stacks in effect; during a blend that of its target."""
        if len(self._channels) == 1:
            return self._channels[0].target.name
        return " + ".join(dict.fromkeys(channel.target.name for channel in self._channels))

    # ---- what comes in between two ticks

    def ask(
        self,
        stack: str,
        duration: float,
        method: str,
        at_tick: int,
        robots: Collection[str] = (),
    ) -> Answer:
        """Return the answer to a request to switch; see RequestBook.ask.

        ``robots`` are the names of those that shall go; empty: all that the stack moves.
        """
        some: tuple[int, ...] | None = None
        if robots and stack in self._stacks:
            moved = [self._team.names[robot] for robot in self._whose[stack]]
            some, refusal = some_of(self._stacks[stack], robots, moved, self._team)
            if refusal:
                return Answer(False, refusal)
        refusal = self._rejection_reason(stack, at_tick, some)
        if refusal:
            return Answer(False, refusal)
        return self._book.ask(stack, duration, method, at_tick, self._tick, robots=some)

    def ask_new(
        self,
        stack: Stack,
        duration: float,
        method: str,
        at_tick: int,
        robots: Collection[str] = (),
    ) -> Answer:
        """Return the answer to a request for a stack whose name nobody knows yet.

        If it is accepted, the stack can be asked for by its name from now on. Whoever solves it in
        the transition must know it too, see ``StackSolver.learn``. The rest is as in ``ask``.
        """
        name = stack.name
        if name in self._stacks:
            return Answer(False, f"stack {name!r} is known already")
        self._stacks[name] = stack
        everyone = tuple(range(len(self._team.robots)))
        self._whose[name] = everyone if stack.robots is None else stack.robots
        answer = self.ask(name, duration, method, at_tick, robots)
        if not answer.accepted:
            del self._stacks[name], self._whose[name]
        return answer

    def set_defaults(self, duration: float, method: str) -> None:
        """Change what an empty duration [s] and method stand for; see RequestBook."""
        self._book.set_defaults(duration, method)

    def request(self, stack: str) -> Answer:
        """Ask as configured, for callers that get no answer: a refusal is shown in the state."""
        answer = self.ask(stack, 0.0, "", 0)
        if not answer.accepted:
            self.note(f"refused: {answer.message}")
        return answer

    def note(self, reason: str) -> None:
        """Show a reason in the state of all robots until their next transition."""
        self._channels = tuple(replace(each, reason=reason) for each in self._channels)

    def cancel(self) -> Answer:
        """Give up all transitions under way and those scheduled, and go back smoothly."""
        given_up = cancelled(self._channels, self._book.not_begun)
        if given_up is None:
            return Answer(False, "there is no transition to cancel")
        self._book.clear()
        self._channels, back, why, done = given_up
        if not back:
            return Answer(True, f"{done} before it began")
        answers = [self._back(stack, why) for stack in back]
        text = "; ".join([done, *(answer.message for answer in answers)])
        return replace(answers[-1], message=text)

    def end(self) -> None:
        """Withdraw all that the source was asked to solve: this object is not used further."""
        self._book.clear()
        self._channels = tuple(replace(each, blend=None) for each in self._channels)

    def hear(self, sample: SourceSample) -> None:
        """Take the source's newest chi of a transition."""
        needed = self._whose.get(sample.stack, ())
        whole = self._merger.join(sample, needed)
        if whole is not None:
            self._sources.hear(whole)

    def hear_plan(self, plan: HeardPlan) -> None:
        """Take a plan of the HTMPC, for the stacks that follow it."""
        self._plans.hear(plan)

    def awaits(self, tick: int, revision: int | None = None) -> bool:
        """Return whether this tick needs a chi of the source that is not there yet (lockstep).

        ``revision`` is that of the references in effect at this tick; None: not known.
        """
        if not self._lockstep:
            return False
        due = self._book.peek(tick)
        self._sample_plans(due, tick)
        if any(self._sources.fresh(request.id, tick, revision) is None for request in due):
            return True
        leaving = {robot for request in due for robot in request.robots}
        return any(
            self._needs(channel, tick, revision)
            for channel in self._channels
            if channel.blend is not None and not leaving.issuperset(channel.group.robots)
        )

    def take_announcements(self) -> list[Announcement]:
        """Return the announcements that the source has not got yet; each is returned once."""
        blends = [channel.blend for channel in self._channels if channel.blend is not None]
        followed = [(blend.request, blend.end) for blend in blends if not blend.alone]
        wanted = wanted_of(self._book.not_begun, followed)
        news = self._announcer.changes(wanted)
        if news:
            self._sources.keep(wanted)
            self._merger.keep(wanted)
        return news

    # ---- the tick

    def due(self, tick: int, revision: int | None = None) -> Due:
        """Return which requests begin at this tick, decided once for all that is done in it.

        Args:
            tick: that is to be served.
            revision: of the references in effect at it; None: not known.
        """
        requested = self._book.peek(tick)
        self._sample_plans(requested, tick)
        if not requested:
            return Due(tick)

        def first(request: SwitchRequest) -> Choice | None:
            source = source_of(self._stacks[request.stack])
            return self._sources.first(request.id, request.at_tick, tick, revision, source)

        return Due.decided(tick, requested, first, self._channels, self._stacks, self._group)

    def limits(self, due: Due) -> tuple[JointLimits, bool]:
        """Return the limits that a tick asks for, and whether a method limits jerk."""
        return self._requested_limits.of(of_tick(self._channels, due, self._stacks, self._group))

    def step(self, due: Due, context: TickContext) -> Plans:
        """Return what the controller solves at this tick.

        While the source's first solution for a new stack is awaited, its robots continue with the
        old stack and the old references: both change together.

        Args:
            due: of this tick.
            context: of this tick.
        """
        self._tick = due.tick
        if due.requested:
            self._book.due(due.tick, due.waiting)
            for request, coupled in due.dropped:
                self._drop(request, coupled)
            for starting in due.starting:
                groups = self._stacks, self._sources, self._group
                self._channels = begin(self._channels, starting, *groups, context)
        held = {robot for request in due.waiting for robot in request.robots}
        channels, plans = [], []
        for channel in self._channels:
            before = channel.used or context.references
            now = context.references
            # A trajectory goes on meanwhile: the decision is the same.
            if held and held.intersection(channel.group.robots) and not now.same_motion(before):
                now = before
            mine = context.between(before, now)
            after, plan = channel.step(mine, self._sources, adopts=self._adopts)
            channels.append(after)
            plans.append(plan)
        self._channels = tuple(channels)
        return Plans.of(plans, [channel.group.columns for channel in channels])

    def finish(self, plans: Plans, chi: Vector) -> tuple[TransitionState, ...]:
        """Return the states to report for this tick, given its chi (n,); adopt at the end."""
        waiting, adopts = (self._book.pending, self._book.scheduled), self._adopts
        states, channels = [], []
        for channel, plan in zip(self._channels, plans.each, strict=True):
            next_ = coming(channel, *waiting) if waiting[0] or waiting[1] else None
            states.append(transition_state(channel, plan, chi, next_, adopts=adopts))
            channels.append(channel.finished(plan, self._sources, adopts=adopts))
        self._channels = tuple(channels)
        if len(channels) > 1:
            self._channels = together(channels, self._group)
        return tuple(states)

    # ---- inside

    def _sample_plans(self, due: Collection[SwitchRequest], tick: int) -> None:
        """Sample the plans that are followed, or will be, at this tick: each enters as a chi."""
        blends = [channel.blend for channel in self._channels if channel.blend is not None]
        followed = {blend.request.id: blend.route for blend in blends if blend.route.target.planned}
        if not followed and not due:
            return
        wanted = {id_: route.group.robots for id_, route in followed.items()}
        wanted |= {r.id: r.robots for r in due if self._stacks[r.stack].planned}
        for id_, robots in wanted.items():
            chi = self._plans.sample(robots, tick)
            if chi is not None:
                self._sources.hear(SourceSample(id_, tick, chi, solved=True))

    def _drop(self, request: SwitchRequest, why: str) -> None:
        """Show in the state of its robots why a request is not served."""
        group = self._group(request.robots)
        reason = f"transition {request.id} to {request.stack!r} is dropped: {why}"
        self._channels = tuple(
            replace(each, reason=reason) if group.shares(each.group) else each
            for each in self._channels
        )

    def _needs(self, channel: Channel, tick: int, revision: int | None) -> bool:
        """Return whether a channel in a blend waits for the solver's chi of this tick."""
        blend = channel.blend
        if blend is None or blend.alone:
            return False
        if self._sources.fresh(blend.request.id, tick, revision) is not None:
            return False
        # A source that was lost is waited for again only after it has sent a chi again.
        return blend.source is source_of(blend.route.target) or self._sources.answered_since(
            blend.request.id, blend.start, revision
        )

    def _rejection_reason(
        self, stack: str, at_tick: int, robots: tuple[int, ...] | None = None
    ) -> str:
        """Return why robots cannot go to a stack at a tick, or ''; 0 is the next one.

        Requests for earlier ticks count as served.
        """
        if stack not in self._stacks:
            return ""  # the request book refuses unknown stacks, and names the known ones
        group = self._group(robots or self._book.robots(stack))
        waiting = self._book.not_begun
        earlier = [each for each in waiting if not at_tick or each.at_tick <= at_tick]
        coupled = coupling(as_requested(self._channels, earlier, self._stacks, self._group), group)
        return coupled and f"stack {stack!r}: {coupled}"

    def _back(self, stack: Stack, reason: str) -> Answer:
        """Ask for a stack that robots were on before."""
        name = stack.name if stack.name in self._stacks else stack.name.removesuffix(AT_REST)
        robots = stack.robots
        return self._book.ask(name, 0.0, "", 0, self._tick, reason=reason, robots=robots)
