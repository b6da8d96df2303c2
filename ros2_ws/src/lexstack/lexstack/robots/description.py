"""Where a robot's description lies: a path, a package, a text, the package example-robot-data."""

from __future__ import annotations

import importlib
import os
from collections.abc import Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from lexstack.errors import ModelError
from lexstack.options import shown

_PACKAGE = "package://"
_BLANKS = str.maketrans({"\t": " ", "\r": " "})  # to XML the same, and options refuse the others
_LARGEST = 20_000_000  # bytes; the largest of example-robot-data has 0.2 MB


def is_text(description: str) -> bool:
    """Return whether a description is a URDF itself, as in ``/robot_description``, and no path."""
    return description.lstrip().startswith("<")


def located(description: str, folder: Path | None = None, packages: Sequence[str] = ()) -> str:
    """Return a description that means the same wherever it is read.

    Args:
        description: a path relative to ``folder``, an absolute path, ``package://NAME/...``, a path
            below example-robot-data's ``robots`` folder, or a URDF's text.
        folder: of the file that names it; None: the working folder.
        packages: folders in which packages lie that no ament index knows, relative to ``folder``;
            each is a package or has packages in it.

    Returns:
        a text with blanks for tabs, a path of example-robot-data as it is, all else as an absolute
        path.

    Raises:
        ModelError: there is no such file or package.
    """
    here = Path() if folder is None else folder
    if is_text(description):
        return description.translate(_BLANKS)
    if description.startswith(_PACKAGE):
        return str(_in_package(description, [here / package for package in packages]))
    beside = here / Path(description).expanduser()  # an absolute path stays as it is
    if _is_file(beside):
        return str(beside.resolve())
    try:
        description_path(description)
    except ModelError as error:
        raise ModelError(f"there is no file {shown(str(beside))}; {error}") from error
    return description


@cache  # every robot of a team asks, and the package has thousands of files
def description_path(description: str) -> Path:
    """Return the file of a description that ``located`` returned and that is no text.

    Raises:
        ModelError: there is none; or it is not absolute, and not in example-robot-data either.
    """
    if Path(description).is_absolute():
        if not _is_file(Path(description)):
            raise ModelError(f"there is no file {shown(description)}")
        return Path(description)
    try:
        listed = files("example-robot-data") or []
    except PackageNotFoundError as error:
        raise ModelError("the package example-robot-data is not installed") from error
    for entry in listed:
        if entry.as_posix().endswith(f"robots/{description}"):
            return Path(str(entry.locate())).resolve()
    raise ModelError(f"example-robot-data has no file {shown(description)} below robots/")


def urdf_text(description: str) -> str:
    """Return the URDF of a description that ``located`` returned; xacro files are expanded.

    Raises:
        ModelError: the file is not there or cannot be read, or the package xacro is missing.
    """
    if is_text(description):
        return description
    path = description_path(description)
    if path.suffix == ".xacro":
        return _expanded(path)
    try:
        with path.open("rb") as file:
            data = file.read(_LARGEST + 1)
        if len(data) > _LARGEST:
            raise ModelError(f"{path}: more than {_LARGEST} bytes")
        return data.decode("utf-8-sig")
    except (OSError, ValueError) as error:
        raise ModelError(f"{path}: cannot be read: {' '.join(str(error).split())}") from error


def _expanded(path: Path) -> str:
    """Return the URDF that a xacro file makes."""
    try:
        xacro = importlib.import_module("xacro")
    except ImportError as error:
        raise ModelError(f"{path}: needs the package xacro, which is not installed") from error
    try:
        return str(xacro.process_file(str(path)).toxml())
    except Exception as error:  # xacro raises its own errors, and any that its expressions raise
        raise ModelError(f"{path}: xacro: {' '.join(str(error).split())}") from error


def _in_package(uri: str, folders: Sequence[Path]) -> Path:
    """Return the file of ``package://NAME/...``: from the ament index, else from ``folders``."""
    name, _, rest = uri.removeprefix(_PACKAGE).partition("/")
    prefixes = [Path(each) for each in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)]
    index = Path("share/ament_index/resource_index/packages")
    shares = [prefix / "share" / name for prefix in prefixes if _is_file(prefix / index / name)]
    given = [path for folder in folders for path in (folder / name, _itself(folder, name)) if path]
    for share in (*shares, *given):
        if _is_file(share / rest):
            return (share / rest).resolve()
    known = f"no file {shown(rest)} in it" if shares or any(map(Path.is_dir, given)) else "unknown"
    raise ModelError(f"{uri}: package {shown(name)}: {known}; key 'packages' names folders of them")


def _itself(folder: Path, name: str) -> Path | None:
    """Return a folder that is the package ``name``, else None."""
    return folder if folder.resolve().name == name else None


def _is_file(path: Path) -> bool:
    """Return whether a file is there; a name that cannot be one's is none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False
