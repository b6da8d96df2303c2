"""What ``colcon test`` runs of this package; all other tests lie in tests/ of the clone."""

import ast
import importlib
from pathlib import Path

import pytest

SETUP = ast.parse((Path(__file__).parents[1] / "setup.py").read_text(encoding="utf-8"))
TEXTS = [str(node.value) for node in ast.walk(SETUP) if isinstance(node, ast.Constant)]
SCRIPTS = [text for text in TEXTS if " = " in text and text.endswith(":main")]


def test_there_are_some() -> None:
    """A package without commands has no such file."""
    assert SCRIPTS


@pytest.mark.parametrize("script", SCRIPTS)
def test_what_an_entry_point_names_is_there(script: str) -> None:
    """Every command of the package can be loaded."""
    module, _, name = script.partition(" = ")[2].partition(":")
    assert callable(getattr(importlib.import_module(module), name))
