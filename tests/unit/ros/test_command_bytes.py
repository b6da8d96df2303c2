"""The controller's chi as bytes: what the generated message holds, at every tick of a switch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from rclpy.serialization import deserialize_message

from lexstack.transition import Phase
from lexstack_experiments.loop import Loop
from lexstack_interfaces.msg import Chi
from lexstack_ros.messages.command_bytes import CommandBytes, TransitionNews
from lexstack_ros.messages.conversions import chi_of_command
from support.scenario import resolved, team


def commands():
    """Return the commands of a run that blends to another stack, adopts it and goes on."""
    loop = Loop(resolved())
    loop.controller.transition.ask("posture", 0.5, "", 5)
    loop.run(120)
    return loop.record.commands


def expected(command):
    message = Chi(robots=list(team().names), sender="me")
    message.header.frame_id = "world"
    return chi_of_command(command, message)


def test_every_command_is_what_the_generated_message_would_be(monkeypatch):
    found = commands()
    near = replace(found[-1], fallback="braking: a test", revision=7, slacks=np.arange(5.0))
    make, made = CommandBytes(team().names, "me"), []
    for command in [*found, near, found[-1], replace(near, transitions=near.transitions * 2)]:
        data = make(command)
        assert deserialize_message(data, Chi) == expected(command)
        made.append(make._buffer)
    phases = {each.transition.phase for each in found}
    assert phases >= {Phase.REQUESTED, Phase.BLENDING, Phase.ADOPTING}
    assert len({id(buffer) for buffer in made}) < 12, "strings change seldom"


def test_transitions_are_news_when_they_change_and_ten_times_a_second():
    found, now, sent = commands(), [0.0], []
    news = TransitionNews(clock=lambda: now[0])
    for command in found:
        sent += [message.tick for message in news.of(command)]
        now[0] += 0.004
    phases = {command.tick: command.transition.phase for command in found}
    changes = [t for t in phases if t and phases[t] != phases[t - 1]]
    assert sent[0] == 0
    assert set(changes) <= set(sent)
    assert len(sent) <= len(changes) + 5, "and at 250 ticks a second not much else"
    quiet = [tick for tick in sent if tick not in changes]
    assert len(quiet) >= 2, "an onlooker who comes later hears it"
