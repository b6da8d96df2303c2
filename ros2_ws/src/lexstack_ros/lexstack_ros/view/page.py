"""The live page's HTML: everything in it but the news."""

from __future__ import annotations

import json
from html import escape
from importlib import resources

from lexstack_bag.report import inline
from lexstack_core.config.resolved import ResolvedScenario
from lexstack_core.model import Team
from lexstack_sim.scene import scene

_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'"
)


def live_page(resolved: ResolvedScenario, team: Team) -> str:
    """Return the page of a run."""
    name = escape(resolved.scenario.name)
    setup = {
        "scene": scene(team),
        "robots": list(team.names),
        "radii": team.obstacles.radii.tolist(),
        "stacks": sorted(resolved.stacks),
    }
    data = json.dumps(setup, separators=(",", ":")).replace("</", "<\\/")
    styles = inline.script("page.css") + _asset("live.css")
    scripts = (
        inline.script("library.js"),
        inline.three(),
        inline.script("view3d.js"),
        _asset("live.js"),
    )
    body = _asset("live.html").replace("{{scenario}}", name)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{name}: lexstack live</title><style>{styles}</style></head>\n<body>{body}"
        f"<script type='application/json' id='setup'>{data}</script>"
        f"{inline.plotly()}"
        f"{inline.scripts(*scripts)}</body></html>\n"
    )


def _asset(name: str) -> str:
    """Return one of this package's texts."""
    folder = resources.files("lexstack_ros.view") / "assets"
    return folder.joinpath(name).read_text(encoding="utf-8")
