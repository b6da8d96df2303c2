"""A user of the live page: finds places in its picture, drags what is there, presses buttons."""

from __future__ import annotations

import time
from contextlib import contextmanager, suppress
from dataclasses import replace
from threading import Event, Thread

import msgspec
import numpy as np
import viser
from viser._messages import ViewerCameraMessage
from websockets.sync.client import connect

from lexstack.robots import Team
from lexstack.types import PlantStatus
from lexstack_config.parts import build_references
from lexstack_ros.view.page.scene import FIELD, camera_for
from lexstack_ros.view.picture import Picture
from support.scenario import home, resolved, team

_PATIENCE = 40.0  # s
_STEPS = 12  # of a drag
# Functions of a label or text that return an element.
_LABELLED = (
    "((text) => [...document.querySelectorAll('label, div, p')].filter((e) => "
    "e.children.length < 2 && e.textContent.trim() === text && e.offsetParent).pop())"
)
_FIELD = (
    f"((text) => {{ let e = {_LABELLED}(text); while (!e.querySelector('input, textarea')) "
    "e = e.parentElement; return e.querySelector('input, textarea'); })"
)
_OPTION = (
    "((text) => [...document.querySelectorAll('[role=option]')]"
    ".find((e) => e.textContent === text && e.offsetParent))"
)


class LivePageUser:
    """Steers a browser that has the page open, as long as its camera has not been moved."""

    def __init__(self, browser, team: Team, home: np.ndarray):
        self.browser = browser
        self.position, self.target = map(np.array, camera_for(team, home))

    def until(self, condition, seconds: float = _PATIENCE):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, "waited in vain"
            time.sleep(0.1)

    def wait_drawn(self, show):
        """Wait until a canvas shows more than the floor, calling ``show`` meanwhile."""

        def drawn():
            show()
            time.sleep(0.3)
            image = self.browser.picture().astype(int)
            return (np.ptp(image, axis=2) > 100).sum() > 3000

        self.until(drawn)

    def pixel(self, point) -> tuple[float, float]:
        """Return where a point of the world [m] is in the window."""
        left, top, width, height = self.browser.run(
            "(() => { const b = [...document.querySelectorAll('canvas')]"
            ".map((c) => c.getBoundingClientRect()).sort((a, b) => b.width - a.width)[0];"
            " return [b.left, b.top, b.width, b.height]; })()"
        )
        ahead = self.target - self.position
        ahead /= np.linalg.norm(ahead)
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        offset = np.array(point) - self.position
        scale = 0.5 * height / np.tan(0.5 * FIELD) / (offset @ ahead)
        x, y = offset @ right, offset @ np.cross(right, ahead)
        return left + 0.5 * width + scale * x, top + 0.5 * height - scale * y

    def pixels(self, origin, axis, way: float = 0.1):
        """Return how far a point moves in the window along an axis by some way [m]."""
        begin = np.array(origin)
        return np.linalg.norm(
            np.subtract(self.pixel(begin + way * np.array(axis)), self.pixel(begin))
        )

    def drag(self, begin, end):
        """Press the mouse at a point of the world, move it to another one, and let go."""
        (x, y), last = self.pixel(begin), self.pixel(end)
        self._mouse("mouseMoved", x, y)
        time.sleep(0.3)
        self._mouse("mousePressed", x, y, down=True)
        for share in np.linspace(0.0, 1.0, _STEPS):
            here = x + share * (last[0] - x), y + share * (last[1] - y)
            self._mouse("mouseMoved", *here, down=True)
            time.sleep(0.08)
        self._mouse("mouseReleased", *last)

    def drag_along(self, origin, axis, way: float, arrow: float = 0.28):
        """Drag the arrow of a gizmo at an origin along an axis by some way [m]."""
        begin = np.array(origin) + 0.8 * arrow * np.array(axis)
        self.drag(begin, begin + way * np.array(axis))

    def press(self, text: str):
        """Press the button that bears a text."""
        self.until(lambda: self.has_button(text))
        self.browser.run(
            f"[...document.querySelectorAll('button')].find((b) => b.textContent === {text!r})"
            ".click()"
        )

    def press_key(self, selector: str, key: str):
        """Press a key on an element."""
        self.browser.run(f"document.querySelector({selector!r}).focus()")
        code = {"End": 35, "Home": 36}[key]
        for kind in ("rawKeyDown", "keyUp"):
            self.browser.call(
                "Input.dispatchKeyEvent",
                type=kind,
                key=key,
                code=key,
                windowsVirtualKeyCode=code,
            )

    def unfold(self, label: str):
        """Open a folder of the panel."""
        self.browser.run(f"{_LABELLED}({label!r}).click()")
        time.sleep(0.5)

    def choose(self, label: str, option: str):
        """Choose an option of the dropdown with a label."""
        self.browser.run(f"{_FIELD}({label!r}).click()")
        self.until(lambda: self.browser.run(f"!!{_OPTION}({option!r})"))
        self.browser.run(f"{_OPTION}({option!r}).click()")
        time.sleep(0.3)  # the page sends it after a moment, and a button at once

    def write(self, label: str, text: str):
        """Write into the field with a label."""
        self.browser.run(f"{_FIELD}({label!r}).focus(); {_FIELD}({label!r}).select()")
        self.browser.call("Input.insertText", text=text)
        time.sleep(0.5)

    def has_button(self, text: str) -> bool:
        return bool(
            self.browser.run(
                "[...document.querySelectorAll('button')].some((b) => b.textContent === "
                f"{text!r} && b.offsetParent !== null)"
            )
        )

    def _mouse(self, kind: str, x: float, y: float, *, down: bool = False):
        button = "none" if kind == "mouseMoved" and not down else "left"
        self.browser.call(
            "Input.dispatchMouseEvent",
            type=kind,
            x=x,
            y=y,
            button=button,
            buttons=int(down),
            clickCount=0 if kind == "mouseMoved" else 1,
        )


@contextmanager
def watching(url: str, origin: str = ""):
    """Look at the page without a browser: connect as a page does, its own, and take what comes."""
    camera = ViewerCameraMessage(
        wxyz=(1.0, 0.0, 0.0, 0.0),
        position=(0.0, 0.0, 1.0),
        fov=1.0,
        near=0.1,
        far=10.0,
        image_height=100,
        image_width=100,
        look_at=(0.0, 0.0, 0.0),
        up_direction=(0.0, 0.0, 1.0),
    )
    stop, heard = Event(), []
    with connect(
        url.replace("http", "ws"),
        origin=origin or url.rstrip("/"),
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
    ) as socket:
        socket.send(msgspec.msgpack.encode(camera.as_serializable_dict()))

        def listen():
            while not stop.is_set():
                with suppress(TimeoutError):
                    heard.append(len(socket.recv(timeout=0.5)))

        thread = Thread(target=listen)
        thread.start()
        try:
            yield heard
        finally:
            stop.set()
            thread.join()


def picture(time=0.0, **values):
    """Return a picture of the default scenario at home, its goals where the tools are."""
    references = build_references(resolved(), team()).at(0.0)
    goals = replace(references, ee=team().tools(home()), base=tuple(team().base_poses(home())))
    one = Picture(
        time=time,
        tick=round(100 * time),
        q=home(),
        plant=PlantStatus.FOLLOWING,
        stack="track",
        phase="idle",
        alpha=0.5,
        source="",
        reason="",
        levels=(0.1, 0.01),
        solve={"robot_a": 0.4},
        references=goals,
        goals=goals,
        obstacles=team().obstacles.at(time),
    )
    return replace(one, **values)
