"""The library's front door: what it shows, that it opens late, and that nobody climbs in behind."""

import ast
import importlib
import inspect
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = ROOT / "ros2_ws/src/lexstack/lexstack"
DOORS = [LIBRARY / "__init__.py", *sorted(LIBRARY.glob("*/__init__.py"))]
MOST = 13  # folders and files that a reader meets at the library's root

# White-box tests of the library itself may reach for what no sub-package exports.
WHITE_BOX = (
    "tests/unit/lexstack/",
    "tests/property",
)


def name_of(file):
    """Return the package whose ``__init__`` a file is."""
    return ".".join(file.parent.relative_to(LIBRARY.parent).parts)


def imports(tree):
    """Return (module, name) of every from-import, and (module, '') of every other one."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)


def listed(file):
    """Return the names of ``__all__``, of the imports for types or at all, and of on_demand."""
    package, shown, typed, late = name_of(file), (), set(), None
    tree = ast.parse(file.read_text())
    for module, name in imports(tree):
        if module.startswith(f"{package}."):
            typed.add((module, name))
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__":
            shown = ast.literal_eval(node.value)
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "on_demand":
            homes = ast.literal_eval(node.args[1])
            late = {(f"{package}.{m}", n) for m, names in homes.items() for n in names.split()}
    return shown, typed, late


@pytest.mark.parametrize("file", DOORS, ids=name_of)
def test_all_lists_of_a_package_s_names_agree(file):
    shown, typed, late = listed(file)
    assert len(set(shown)) == len(shown) > 0
    defined = {node.name for node in ast.parse(file.read_text()).body if hasattr(node, "name")}
    constants = set(re.findall(r"^([A-Z_]+)\b.* = ", file.read_text(), flags=re.MULTILINE))
    assert set(shown) - defined - constants <= {name for _, name in typed}
    assert late is None or typed == late, "for types and on demand"
    assert late is None or set(shown) == {name for _, name in late}


def documented(module, name):
    """Return whether a name has a docstring in the module that defines it."""
    value = inspect.unwrap(getattr(module, name))
    if inspect.isclass(value) or inspect.isfunction(value):
        module = sys.modules[value.__module__]
        tree = ast.parse(inspect.getsource(value))
        return bool(ast.get_docstring(tree.body[0]))
    body = ast.parse(inspect.getsource(module)).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(getattr(target, "id", "") == name for target in targets):
            return isinstance(after, ast.Expr) and isinstance(after.value.value, str)
    return False


@pytest.mark.parametrize("file", DOORS, ids=name_of)
def test_every_public_name_is_there_and_has_a_docstring(file):
    package = importlib.import_module(name_of(file))
    shown, typed, _ = listed(file)
    homes = {name: module for module, name in typed}
    without = []
    for name in shown:
        module = importlib.import_module(homes.get(name, name_of(file)))
        while name in (found := dict(reversed([*imports_of(module)]))):  # a front door behind it
            module = importlib.import_module(found[name])
        assert getattr(package, name) is getattr(module, name)
        if not documented(module, name):
            without.append(name)
    assert not without


def imports_of(module):
    """Return (name, module) of what a module imports from the library."""
    tree = ast.parse(inspect.getsource(module))
    return [(name, home) for home, name in imports(tree) if home.startswith("lexstack.")]


def test_an_unknown_name_is_an_attribute_error():
    import lexstack

    with pytest.raises(AttributeError, match="'lexstack' has no attribute 'Nothing'"):
        lexstack.Nothing  # noqa: B018


@pytest.mark.parametrize(
    ("statement", "absent"),
    [
        ("import lexstack", "numpy scipy casadi pinocchio yaml"),
        ("from lexstack import Team, StackConfig, HtmpcConfig", "scipy casadi proxsuite yaml"),
        ("from lexstack_config.resolved import load_scenario", "scipy casadi proxsuite"),
        ("from lexstack_config.parts import build_controller", "scipy.optimize casadi"),
        ("from lexstack import SequenceTask", "scipy.optimize casadi"),
    ],
)
def test_what_is_not_needed_is_not_loaded(statement, absent):
    code = f"import sys; {statement}; print(*(set('{absent}'.split()) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_a_reader_meets_few_things_at_the_root():
    found = [path.name for path in LIBRARY.iterdir() if path.name != "__pycache__"]
    found.remove("py.typed")  # a mark for type checkers, empty
    assert len(found) <= MOST, sorted(found)


def test_the_library_itself_does_not_come_in_by_the_front_door():
    """Its layers could not be checked else: the front door has names of all of them."""
    for file in LIBRARY.rglob("*.py"):
        text = file.read_text()
        names = {name for module, name in imports(ast.parse(text)) if module == "lexstack"}
        assert names <= ({"on_demand"} if file in DOORS else set()), file
        assert file in DOORS or "TYPE_CHECKING" not in text, file


def deep(tree):
    """Return the imports that reach deeper than one sub-package of the library."""
    found = [(module, name) for module, name in imports(tree) if module.startswith("lexstack.")]
    return [(module, name) for module, name in found if module.count(".") > 1]


def outside():
    """Return every Python file of ours that is not the library's."""
    folders = ["ros2_ws/src", "sim_bridge", "scripts", "tests", "examples"]
    files = (file for folder in folders for file in (ROOT / folder).rglob("*.py"))
    return sorted(file for file in files if LIBRARY not in file.parents)


def test_nobody_reaches_deeper_than_one_sub_package():
    wrong = []
    for file in outside():
        place = str(file.relative_to(ROOT))
        for module, name in deep(ast.parse(file.read_text())):
            door = importlib.import_module(".".join(module.split(".")[:2]))
            if not place.startswith(WHITE_BOX) or name in door.__all__:
                wrong.append(f"{place}: from {module} import {name}")
    assert not wrong, "\n".join(wrong)


def test_no_page_teaches_to_reach_deeper():
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    wrong = []
    for page in pages:
        for block in re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.M | re.S):
            wrong += [f"{page.name}: {found}" for found in deep(ast.parse(block))]
    assert not wrong


def test_the_check_sees_a_deep_import():
    tree = ast.parse(
        "from lexstack.limits.stopping import approach_speed\nimport lexstack.mpc.plan"
    )
    assert len(deep(tree)) == 2
    assert not deep(ast.parse("from lexstack.limits import Bounds\nimport lexstack_bag.run.reader"))


def test_a_user_s_program_has_types():
    """The checker finds the misspelt argument in it, or the excuse for that would be unused."""
    program = ROOT / "tests/architecture/typed_program.py"
    command = [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml", program]
    environment = {**os.environ, "MYPYPATH": str(LIBRARY.parent)}
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=ROOT, env=environment
    )
    assert done.returncode == 0, done.stdout
