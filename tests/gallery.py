"""Makes the documents' pictures anew: report and live page by Chromium, robots, examples."""

from __future__ import annotations

import argparse
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image

from lexstack.robots import Pose, RobotModel, Team
from lexstack_config.parts import build_team, home_of
from lexstack_config.resolved import load_robot, load_scenario
from lexstack_sim.render import Renderer
from support.browser import Browser, find_browser
from support.view import LivePageUser

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
from website import examples  # noqa: E402

IMAGES = ROOT / "docs/images"
SENT = """name: elbow
description: tools, height of the elbow, then rest
levels:
- tasks: [{type: ee_pose}]
- tasks: [{type: frame_position, parameters: {frame: panda_link4, mask: [false, false, true]}}]
- tasks: [{type: velocity_damping}]
"""
COLORS = 192  # of a picture: small files, and no difference to see


def save(path: Path, image, colors: int = COLORS) -> None:
    """Write a small PNG."""
    picture = Image.fromarray(image).quantize(colors, dither=Image.Dither.NONE)
    picture.save(path, optimize=True)
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB")


def report(path: Path, at: float) -> None:
    """Take the report's pictures: its top, its 3-D view at a time [s], its first switch."""
    with Browser((1200, 1150)) as page:
        page.open(path.as_uri())
        page.wait("document.documentElement.dataset.drawn")
        page.run(f"LexstackPlayer.show({at})")
        save(IMAGES / "view.png", page.picture("#view-section"))
        save(IMAGES / "switch.png", page.picture("#switch-a-section"))
        page.run("scrollTo(0, 0)")
        save(IMAGES / "report.png", page.picture())


def sequences(path: Path) -> None:
    """Take the pictures of a report with sequences of tasks: which was when, ways from above."""
    with Browser((1200, 1150)) as page:
        page.open(path.as_uri())
        page.wait("document.documentElement.dataset.drawn")
        save(IMAGES / "delivery-tasks.png", page.picture("#tasks-section"))
        save(IMAGES / "delivery-paths.png", page.picture("#sequence-paths-section"))


def live() -> None:
    """Take a picture of the live page: a stack that is sent, and a target that is dragged."""
    resolved = load_scenario(ROOT / "config/scenarios/by-hand.yaml")
    team = build_team(resolved)
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "lexstack_bringup.commands.demo", "by-hand", "--view"]
        command += ["--mode", "lockstep"]  # drawing without a graphics card makes ticks late
        run = subprocess.Popen(
            [*command, "--out", f"{folder}/run"], stdout=subprocess.PIPE, text=True, cwd=ROOT
        )
        try:
            url = next(found[0] for line in run.stdout if (found := re.search(r"http://\S+", line)))
            with Browser((1500, 950)) as page:
                page.open(url)
                user = LivePageUser(page, team, home_of(team, resolved))
                page.wait("document.body.textContent.includes('ticks/s')", 90)
                page.run("document.querySelector('.mantine-Notification-closeButton')?.click()")
                _send_and_drag(page, user, team.tools(home_of(team, resolved))[0])
                save(IMAGES / "live.png", page.picture())
        finally:
            run.send_signal(signal.SIGINT)
            run.wait(60)


def _send_and_drag(page: Browser, user: LivePageUser, tool: Pose) -> None:
    """Switch to a stack that is written on the page, and drag the tool while α rises."""
    user.unfold("Stack as text")
    user.write("YAML", SENT)
    user.write("in [s]", "20")
    user.press("Switch to text")
    page.wait("document.body.textContent.includes('blending')", 60)
    user.drag_along(tool.position, tool.rotation[:, 2], -0.3)
    page.wait("document.body.textContent.includes('target sent')", 30)
    time.sleep(0.3)


def robots() -> None:
    """Draw each robot that stands in config/robots alone, without a platform of ours, at home."""
    for path in sorted((ROOT / "config/robots").glob("*.yaml")):
        config = load_robot(path)
        if config.base is not None and config.base.chassis_mass:
            continue
        team = Team((RobotModel(path.stem, config),), 0.01)
        with Renderer(team, (360, 360)) as renderer:
            renderer.frame([team.home()], azimuth=145.0, elevation=-15.0)
            save(IMAGES / "robots" / f"{path.stem}.png", renderer.picture(team.home()), 128)


def main() -> int:
    """Run the command; return its exit code."""
    parser = argparse.ArgumentParser(prog="./scripts/gallery", description=__doc__)
    parser.add_argument(
        "run", type=Path, nargs="?", help="run folder of the demo, with its report.html"
    )
    parser.add_argument("--delivery", type=Path, help="run folder of the demo delivery; no others")
    parser.add_argument("--at", type=float, default=18.3, help="time of the 3-D view [s]")
    parser.add_argument(
        "--examples", nargs="*", metavar="NAME", help="run and draw examples, or all; no others"
    )
    parser.add_argument("--robots", action="store_true", help="draw config/robots; no others")
    parser.add_argument("--live", action="store_true", help="take the live page; no others")
    options = parser.parse_args()
    if options.examples is not None:
        examples.write(tuple(options.examples))
        return 0
    if options.robots or options.live:
        (robots if options.robots else live)()
        return 0
    folder = options.delivery or options.run
    if folder is None:
        parser.error("a run folder, or --delivery with one, is needed")
    path = folder.resolve() / "report.html"
    if not path.is_file():
        print(f"gallery: {path}: no such file; run ./scripts/demo first", file=sys.stderr)
        return 2
    if find_browser() is None:
        print("gallery: no Chromium; install chromium", file=sys.stderr)
        return 2
    if options.delivery is not None:
        sequences(path)
        return 0
    report(path, options.at)
    live()
    return 0


if __name__ == "__main__":
    sys.exit(main())
