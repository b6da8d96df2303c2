"""The controller's transitions from stack to stack: which robots go where, and what comes next."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from lexstack.limits.joint_limits import JointLimits
from lexstack.options import shown
from lexstack.robots import Team
from lexstack.tasks.stack import AT_REST, Stack
from lexstack.transition.channel_problem import Plans
from lexstack.transition.channels.channel import Channel, asked_of
from lexstack.transition.channels.gathering import begun, together
from lexstack.transition.channels.lineup import as_asked, coupling, references_before, without
from lexstack.transition.due import Due
from lexstack.transition.messages import Announcement, Phase, SourceSample, TransitionState
from lexstack.transition.methods import JERK_LIMITED, METHODS
from lexstack.transition.options import TransitionOptions
from lexstack.transition.requested_limits import RequestedLimits
from lexstack.transition.requests import Answer, RequestBook, SwitchRequest, in_effect
from lexstack.transition.robot_group import RobotGroup
from lexstack.transition.sources.announcements import Announcer, Wanted
from lexstack.transition.sources.inbox import Choice, LocalSource, Sources
from lexstack.transition.sources.mpc_plans import HeardPlan, PlanBook
from lexstack.transition.sources.partial_samples import PartialSampleMerger
from lexstack.transition.status_report import transition_state
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
        """
        everyone = tuple(range(len(team.robots)))
        whose = {
            name: everyone if stack.robots is None else stack.robots
            for name, stack in stacks.items()
        }
        self._stacks = stacks
        self._team = team
        self._whose = whose
        self._joiner = PartialSampleMerger(team)
        self._sources = Sources(local, options)
        self._plans = PlanBook(team, options)
        self._book = RequestBook(whose, METHODS, options.switch, unfit, horizon=options.horizon)
        self._adopts = options.switch.at_end == "adopt"
        self._lockstep = options.lockstep
        self._asked = RequestedLimits(team.limits, always=options.limit_jerk)
        self._announcer = Announcer()
        self._tick = 0
        self._pending: tuple[SwitchRequest, ...] = ()  # due, but without a first chi
        self._parts = {everyone: RobotGroup.of(team, everyone)}
        initial = stacks[options.initial].of(everyone)
        first = Channel(self._parts[everyone], (initial,), initial.name)
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
            strangers = [name for name in robots if name not in self._moved(stack)]
            if strangers:
                known = ", ".join(self._moved(stack))
                return Answer(
                    False, f"stack {stack!r} does not move {shown(strangers[0])}, but {known}"
                )
            if len(set(robots)) < len(robots):
                return Answer(False, "robots: a name stands in it twice")
            some = tuple(sorted({self._team.index(name) for name in robots}))
            task = self._stacks[stack].coupling(some)
            if task:
                return Answer(False, f"the task {task!r} of {stack!r} couples more robots")
        refusal = self._refusal(stack, at_tick, some)
        if refusal:
            return Answer(False, refusal)
        return self._book.ask(stack, duration, method, at_tick, self._tick, robots=some)

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
        dropped = (*self._pending, *self._book.scheduled)
        self._book.clear()
        self._pending = ()
        blends = [channel for channel in self._channels if channel.blend is not None]
        if not dropped and not blends:
            return Answer(False, "there is no transition to cancel")
        gone = dict.fromkeys(channel.id for channel in blends)
        gone = gone or dict.fromkeys(request.id for request in dropped[-3:])
        plural = "s" if len(gone) > 1 else ""
        what = f"transition{plural} {', '.join(map(str, gone))}"
        if not blends and len(dropped) > len(gone):
            what = f"{len(dropped)} transitions, the last of them {', '.join(map(str, gone))},"
        why = f"{what} {'were' if plural else 'was'} cancelled"
        concerned = {id(channel) for channel in blends} or {id(each) for each in self._channels}
        self._channels = tuple(
            replace(each, aborted=why) if id(each) in concerned else each for each in self._channels
        )
        done = f"{what} {'are' if plural else 'is'} cancelled"
        if not blends:
            return Answer(True, f"{done} before it began")
        back = [stack for channel in blends for stack in channel.adopted]
        answers = [self._back(stack, f"{why}; going back") for stack in back]
        text = "; ".join([done, *(answer.message for answer in answers)])
        return replace(answers[-1], message=text)

    def end(self) -> None:
        """Withdraw all that the source was asked to solve: this object is not used further."""
        self._book.clear()
        self._pending = ()
        self._channels = tuple(replace(each, blend=None) for each in self._channels)

    def hear(self, sample: SourceSample) -> None:
        """Take the source's newest chi of a transition."""
        needed = self._whose.get(sample.stack, ())
        whole = self._joiner.join(sample, needed)
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
        due = self._asked_for(tick)
        self._sample_plans(due, tick)
        if any(self._sources.fresh(request.id, tick, revision) is None for request in due):
            return True
        leaving = {robot for request in due for robot in request.robots}
        return any(
            self._needs(channel, tick, revision)
            for channel in self._channels
            if channel.blend is not None and not leaving.issuperset(channel.part.robots)
        )

    def take_announcements(self) -> list[Announcement]:
        """Return the announcements that the source has not got yet; each is returned once."""
        wanted: dict[int, Wanted] = {
            request.id: (request, None) for request in (*self._pending, *self._book.scheduled)
        }
        for channel in self._channels:
            blend = channel.blend
            if blend is None or blend.alone:
                continue
            id_, end = blend.request.id, blend.end
            if id_ in wanted:
                other = wanted[id_][1]
                end = None if end is None or other is None else max(end, other)
            wanted[id_] = (blend.request, end)
        news = self._announcer.changes(wanted)
        if news:
            self._sources.keep(wanted)
            self._joiner.keep(wanted)
        return news

    # ---- the tick

    def due(self, tick: int, revision: int | None = None) -> Due:
        """Return which requests begin at this tick, decided once for all that is done in it.

        A request waits for the solver's first chi, and for every older one that shares a robot. One
        whose robots are coupled with others by now is dropped.

        Args:
            tick: that is to be served.
            revision: of the references in effect at it; None: not known.
        """
        asked = self._asked_for(tick)
        self._sample_plans(asked, tick)
        if not asked:
            return Due(tick)
        starting, waiting, dropped = [], [], []
        held, channels = set[int](), list(self._channels)
        for request in asked:
            source = asked_of(self._stacks[request.stack])
            first = self._sources.first(request.id, request.at_tick, tick, revision, source)
            if first is None or held.intersection(request.robots):
                waiting.append(request)
                held.update(request.robots)
                continue
            part = self._part(request.robots)
            touched = [each for each in channels if part.shares(each.part)]
            coupled = coupling(touched, part)
            if coupled:
                dropped.append((request, coupled))
                continue
            starting.append((request, first))
            channels = as_asked(channels, [request], self._stacks, self._part)
        return Due(tick, tuple(starting), tuple(waiting), tuple(dropped))

    def limits(self, due: Due) -> tuple[JointLimits, bool]:
        """Return the limits that a tick asks for, and whether a method limits jerk."""
        ways = [(channel.part, channel.target, channel.method) for channel in self._channels]
        for request, _ in due.starting:
            stay = [set(part.robots) - set(request.robots) for part, _, _ in ways]
            ways = [
                (self._part(robots), stack, method)
                for robots, (_, stack, method) in zip(stay, ways, strict=True)
                if robots
            ]
            goal = (self._part(request.robots), self._stacks[request.stack], request.method)
            ways.append(goal)
        return self._asked.of(
            [(part.columns, stack.limits, method in JERK_LIMITED) for part, stack, method in ways]
        )

    def step(self, due: Due, context: TickContext) -> Plans:
        """Return what the controller solves at this tick.

        While the source's first solution for a new stack is awaited, its robots continue with the
        old stack and the old references: both change together.

        Args:
            due: of this tick.
            context: of this tick.
        """
        self._tick = due.tick
        if due.asked:
            self._book.due(due.tick)
            self._pending = due.waiting
            for request, coupled in due.dropped:
                self._drop(request, coupled)
            for request, first in due.starting:
                self._begin(request, first, context)
        held = {robot for request in due.waiting for robot in request.robots}
        channels, plans = [], []
        for channel in self._channels:
            before = channel.used or context.references
            now = context.references
            # A trajectory goes on meanwhile: the decision is the same.
            if held and held.intersection(channel.part.robots) and not now.same_motion(before):
                now = before
            mine = context.between(before, now)
            after, plan = channel.step(mine, self._sources, adopts=self._adopts)
            channels.append(after)
            plans.append(plan)
        self._channels = tuple(channels)
        return Plans.of(plans, [channel.part.columns for channel in channels])

    def finish(self, plans: Plans, chi: Vector) -> tuple[TransitionState, ...]:
        """Return the states to report for this tick, given its chi (n,); adopt at the end."""
        pairs = list(zip(self._channels, plans.each, strict=True))
        states = tuple(
            transition_state(channel, plan, chi, self._coming(channel), adopts=self._adopts)
            for channel, plan in pairs
        )
        channels = tuple(
            channel.finished(plan, self._sources, adopts=self._adopts) for channel, plan in pairs
        )
        self._channels = channels if len(channels) == 1 else together(channels, self._part)
        return states

    # ---- inside

    def _sample_plans(self, due: Collection[SwitchRequest], tick: int) -> None:
        """Sample the plans that are followed, or will be, at this tick: each enters as a chi."""
        blends = [channel.blend for channel in self._channels if channel.blend is not None]
        if not blends and not due:
            return
        followed = {blend.request.id: blend.way for blend in blends if blend.way.target.planned}
        wanted = {id_: way.part.robots for id_, way in followed.items()}
        wanted |= {r.id: r.robots for r in due if self._stacks[r.stack].planned}
        for id_, robots in wanted.items():
            chi = self._plans.sample(robots, tick)
            if chi is not None:
                self._sources.hear(SourceSample(id_, tick, chi, solved=True))

    def _asked_for(self, tick: int) -> tuple[SwitchRequest, ...]:
        """Return the requests whose tick has come, the older ones first."""
        due = self._book.peek(tick)
        return in_effect((*self._pending, *due)) if due else self._pending

    def _drop(self, request: SwitchRequest, why: str) -> None:
        """Show in the state of its robots why a request is not served."""
        part = self._part(request.robots)
        reason = f"transition {request.id} to {request.stack!r} is dropped: {why}"
        self._channels = tuple(
            replace(each, reason=reason) if part.shares(each.part) else each
            for each in self._channels
        )

    def _begin(self, request: SwitchRequest, first: Choice, context: TickContext) -> None:
        """Move a request's robots from their channels into a new one, in a blend."""
        part = self._part(request.robots)
        touched = [each for each in self._channels if part.shares(each.part)]
        inside = [each.of(self._part(set(each.part.robots) & set(part.robots))) for each in touched]
        target = self._stacks[request.stack].of(part.robots)
        references = context.references
        context = context.between(references_before(inside, references), references)
        whole = target is self._stacks[request.stack]
        level = target.first(context.kinematics, references) if whole else ()
        choice = self._sources.checked(first, context, level)
        chi = self._sources.chi(choice, target, context)
        channel = begun(inside, request, (part, target, whole), (choice, chi), context)
        others = without(self._channels, part.robots, self._part)
        self._channels = tuple(sorted([*others, channel], key=lambda each: each.part.robots))

    def _needs(self, channel: Channel, tick: int, revision: int | None) -> bool:
        """Return whether a channel in a blend waits for the solver's chi of this tick."""
        blend = channel.blend
        if blend is None or blend.alone:
            return False
        if self._sources.fresh(blend.request.id, tick, revision) is not None:
            return False
        # A source that was lost is waited for again only after it has sent a chi again.
        return blend.source is asked_of(blend.way.target) or self._sources.answered_since(
            blend.request.id, blend.start, revision
        )

    def _coming(self, channel: Channel) -> tuple[SwitchRequest, Phase] | None:
        """Return the next request that takes robots of a channel, and how far it is."""
        robots = set(channel.part.robots)
        for requests, phase in (
            (self._pending, Phase.PREPARING),
            (self._book.scheduled, Phase.REQUESTED),
        ):
            for request in requests:
                if robots.intersection(request.robots):
                    return request, phase
        return None

    def _moved(self, stack: str) -> tuple[str, ...]:
        """Return the names of the robots that a known stack moves."""
        return tuple(self._team.names[robot] for robot in self._book.robots(stack))

    def _refusal(self, stack: str, at_tick: int, robots: tuple[int, ...] | None = None) -> str:
        """Return why robots cannot go to a stack at a tick, or ''; 0 is the next one.

        Requests for earlier ticks count as served.
        """
        if stack not in self._stacks:
            return ""  # the request book refuses unknown stacks, and names the known ones
        part = self._part(robots or self._book.robots(stack))
        earlier = [
            request
            for request in (*self._pending, *self._book.scheduled)
            if not at_tick or request.at_tick <= at_tick
        ]
        channels = as_asked(self._channels, earlier, self._stacks, self._part)
        coupled = coupling([each for each in channels if part.shares(each.part)], part)
        return coupled and f"stack {stack!r}: {coupled}"

    def _back(self, stack: Stack, reason: str) -> Answer:
        """Ask for a stack that robots were on before."""
        name = stack.name if stack.name in self._stacks else stack.name.removesuffix(AT_REST)
        robots = stack.robots
        return self._book.ask(name, 0.0, "", 0, self._tick, reason=reason, robots=robots)

    def _part(self, robots: Iterable[int]) -> RobotGroup:
        """Return the part of some robots, made when first asked for."""
        key = tuple(sorted(robots))
        if key not in self._parts:
            self._parts[key] = RobotGroup.of(self._team, key)
        return self._parts[key]
