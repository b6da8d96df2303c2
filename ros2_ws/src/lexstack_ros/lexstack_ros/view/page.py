"""The live page's HTML: everything in it but the news."""

from __future__ import annotations

from importlib import resources

from lexstack.robots import Team
from lexstack_bag.report import inline
from lexstack_bag.report.html import json_text, new_nonce, policy, render, render_text, trusted
from lexstack_config.resolved import ResolvedScenario
from lexstack_sim.scene import scene


def live_page(resolved: ResolvedScenario, team: Team) -> str:
    """Return the page of a run: its scripts run, no others."""
    setup = {
        "scene": scene(team),
        "robots": list(team.names),
        "radii": team.obstacles.radii.tolist(),
        "stacks": sorted(resolved.stacks),
    }
    scripts = (
        inline.script("library.js"),
        inline.three(),
        inline.script("view3d.js"),
        trusted(_asset("live.js")),
    )
    name, nonce = resolved.scenario.name, new_nonce()
    return render(
        "document.html",
        title=f"{name}: lexstack live",
        body=render_text(_asset("live.html"), scenario=name, setup=json_text(setup)),
        nonce=nonce,
        policy=policy(nonce, "connect-src 'self'"),
        styles=inline.script("page.css") + trusted(_asset("live.css")),
        plotly=inline.plotly(),
        scripts=scripts,
    )


def _asset(name: str) -> str:
    """Return one of this package's texts."""
    folder = resources.files("lexstack_ros.view") / "assets"
    return folder.joinpath(name).read_text(encoding="utf-8")
