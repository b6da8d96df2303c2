"""Names that try to become a part of the live page, in everything that it shows."""

from __future__ import annotations

import time
from dataclasses import replace

from lexstack_config.parts import build_references, build_team, home_of
from lexstack_interfaces.msg import Chi, PlantState, TransitionStatus
from lexstack_ros.view.hub import Hub
from lexstack_ros.view.news import news
from lexstack_ros.view.page import live_page
from lexstack_ros.view.server import ViewError, ViewServer
from support.browser import Browser
from support.hostile import ALL, assert_harmless, shown
from support.scenario import resolved


def hostile():
    """Return the scenario with names that its configuration would refuse."""
    known = resolved()
    robots = {f"{name}{ALL}": place for name, place in known.scenario.robots.items()}
    scenario = replace(known.scenario, name=f"name{ALL}", robots=robots)
    stacks = known.stacks | {f"stack{ALL}": known.stacks["track"]}
    return replace(known, scenario=scenario, stacks=stacks)


def told(run, team, second=0):
    """Return news whose every text is hostile."""
    status = TransitionStatus(
        phase=TransitionStatus.BLENDING,
        from_stack=f"from{ALL}",
        to_stack=f"to{ALL}",
        source=f"source{ALL}",
        reason=f"reason{ALL}",
        robots=[team.names[0]],
    )
    state = PlantState(tick=7, q=home_of(team, run).tolist(), status=PlantState.BRAKING)
    state.header.stamp.sec = second
    references = build_references(known_by_names(run), team).at(0.0)
    chi = {f"chi{ALL}": Chi(tick=7, slacks=[0.1], solve_time=0.001)}
    return news(team, state, [status], chi, references)


def known_by_names(run):
    """Return the scenario without references, which are told by the robots' proper names."""
    return replace(run, scenario=replace(run.scenario, ee_target={}, base_target={}))


def test_the_live_page_shows_hostile_names_and_runs_none():
    run = hostile()
    team = build_team(run)
    hub = Hub()

    def refuse(_body):
        raise ViewError(f"answer{ALL}")

    server = ViewServer(live_page(run, team), hub, refuse)
    try:
        with Browser() as page:
            page.open(server.url)
            page.wait("window.LexstackLive !== undefined")
            drawn = "(document.getElementById('strips').layout?.shapes?.length || 0) > 0"
            for second in range(1, 300):  # the page may still be finding its way to the server
                hub.publish(told(run, team, second))
                if page.run(drawn):
                    break
                time.sleep(0.1)
            assert page.run("document.getElementById('strips').layout.shapes[0].name") == "braking"
            page.run("LexstackLive.order({do: 'cancel'})")
            for name in ("name", "to", "reason", "stack", f"{team.names[0]}"):
                assert shown(page, name if name == team.names[0] else f"{name}{ALL}"), name
            legend = page.run(
                "[...document.querySelectorAll('#strips .legendtext')].map(t => t.textContent)"
            )
            assert f"solve time chi{ALL}" in legend
            assert page.run("document.getElementById('plant').className") == "bad"
            page.messages = [text for text in page.messages if "409" not in text]
            assert_harmless(page)
    finally:
        hub.close()
        server.close()
