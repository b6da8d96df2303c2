"""Which packages the API pages show, and which of their public names have no docstring."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import griffe
import yaml

Thing = griffe.Object | griffe.Alias


@dataclass(frozen=True)
class ApiList:
    """The packages of the API pages, and the folders in which they are looked for."""

    packages: tuple[str, ...]
    folders: tuple[Path, ...]


class _Loader(yaml.SafeLoader):
    """Reads mkdocs.yml as plain data: its tags name Python objects, of which nothing is needed."""


_Loader.add_multi_constructor("tag:yaml.org,2002:python/", lambda *_: None)


def api_list(root: Path) -> ApiList:
    """Return the list that stands in ``mkdocs.yml`` below ``extra: api``."""
    text = (root / "mkdocs.yml").read_text(encoding="utf-8")
    extra = yaml.load(text, Loader=_Loader)["extra"]  # noqa: S506 (a safe loader)
    folders = tuple(path for path in sorted(root.glob("ros2_ws/src/*")) if path.is_dir())
    return ApiList(packages(extra), folders)


def packages(extra: dict[str, object]) -> tuple[str, ...]:
    """Return the full names of the packages, the library first."""
    api = extra["api"]
    assert isinstance(api, dict)
    library = api["library"]
    return (library, *(f"{library}.{name}" for name in api["packages"]))


def load(api: ApiList) -> dict[str, Thing]:
    """Return the packages as griffe sees them, by name, without importing them."""
    loader = griffe.GriffeLoader(search_paths=list(api.folders), docstring_parser="google")
    loader.load(api.packages[0])
    loader.resolve_aliases()
    return {name: loader.modules_collection[name] for name in api.packages}


def missing(api: ApiList) -> list[str]:
    """Return the public names without a docstring, sorted; fields of a class are not counted.

    A field is told of in the docstring of its class, which ruff looks at.
    """
    return sorted({path for package in load(api).values() for path in _without(package)})


def hidden(package: Thing) -> list[str]:
    """Return the paths of public names that have the name of a submodule.

    ``from package.thing import thing`` makes ``package.thing`` the function; griffe, which runs
    nothing, takes it for the module and leaves the function out.
    """
    modules = [member for member in package.members.values() if _is_public_module(member)]
    return [f"{_target(module).path}.{module.name}" for module in modules]


def _without(thing: Thing) -> Iterator[str]:
    """Yield the paths of a name and of what is public in it, as far as they have no docstring."""
    if not thing.has_docstring:
        yield thing.path
    if thing.is_module or thing.is_class:
        for member in thing.members.values():
            if _is_shown(thing, member):
                yield from _without(_target(member))
            elif _is_public_module(member):
                yield from _without(_target(_target(member).members[member.name]))


def _target(thing: Thing) -> Thing:
    """Return what an alias stands for, else the thing itself."""
    return thing.final_target if isinstance(thing, griffe.Alias) else thing


def _is_public_module(member: Thing) -> bool:
    """Return whether a member is exported, and is a module with a member of its own name."""
    return member.is_exported and member.is_module and member.name in _target(member).members


def _is_shown(parent: Thing, member: Thing) -> bool:
    """Return whether the API page of ``parent`` shows a member."""
    if member.name.startswith("_"):
        return False
    if parent.is_module and parent.exports is not None:
        return member.is_exported and not member.is_module
    own = not member.is_alias and not member.is_module
    return own and not (parent.is_class and member.is_attribute)
