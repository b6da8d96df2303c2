"""What a page carries in itself: our scripts and styles, plotly.js and three.js."""

from __future__ import annotations

import base64
import gzip
import zipfile
from functools import lru_cache
from importlib import resources

from markupsafe import Markup

from lexstack_bag.errors import BagError
from lexstack_bag.report.html import trusted

# trimesh's wheel carries three.js in the template of its viewer: the library, then controls, then
# loaders and trimesh's own code, which are left out here.
_TEMPLATE = ("resources/templates/viewer.zip", "viewer.html.template")
_BEGIN, _END = "<script>", "THREE.TrackballControls=TrackballControls;})();"


def script(name: str) -> Markup:
    """Return one of our scripts or styles, ready to stand in a page."""
    folder = resources.files("lexstack_bag.report") / "assets"
    return trusted(folder.joinpath(name).read_text(encoding="utf-8"))


@lru_cache(maxsize=1)
def plotly() -> Markup:
    """Return a script element with plotly.js (MIT), compressed: see ``library.js``."""
    from plotly.offline import get_plotlyjs  # noqa: PLC0415 - slow to load

    packed = gzip.compress(str(get_plotlyjs()).encode(), mtime=0)
    text = base64.b64encode(packed).decode("ascii")
    return trusted(f"<script type='text/plain' id='plotly'>{text}</script>")


@lru_cache(maxsize=1)
def three() -> Markup:
    """Return three.js with TrackballControls (MIT), which defines THREE.

    Raises:
        BagError: the installed trimesh does not carry it as expected.
    """
    archive, member = _TEMPLATE
    with (
        resources.files("trimesh").joinpath(archive).open("rb") as file,
        zipfile.ZipFile(file) as templates,
    ):
        text = templates.read(member).decode("utf-8")
    begin, end = text.find(_BEGIN), text.find(_END)
    if begin < 0 or end < 0:
        raise BagError(
            f"trimesh: {archive} does not hold three.js as expected; install trimesh 5.2"
        )
    return trusted(text[begin + len(_BEGIN) : end + len(_END)])
