"""What the documents say exists: commands, paths, links, names, topics; and nothing leaks."""

import ast
import dataclasses
import importlib
import inspect
import os
import re
import subprocess
from contextlib import suppress
from functools import cache
from pathlib import Path

import pytest

from lexstack.transition import TransitionConfig
from lexstack_config.plant import PlantConfig, PushConfig
from lexstack_config.reference_topics import ReferenceTopicsConfig
from lexstack_config.scenario import EventConfig, ScenarioConfig
from lexstack_config.stream import StreamConfig
from lexstack_config.trajectories import (
    PathConfig,
    PostureWayConfig,
    TwistEventConfig,
    WayConfig,
)

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
BY_HAND = ROOT / "docs/ros-by-hand.md"
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
SOURCES = ("ros2_ws/src/*/lexstack*", "sim_bridge/lexstack_sim", "scripts", "tests")
# Where a path in a document may begin, beside the root and the document's own folder.
BASES = ("ros2_ws/src/*", "ros2_ws/src/*/lexstack*", "sim_bridge")

# What a run leaves; the documents name it, no clone has it.
RUN_FILES = {
    "bag/",
    "bag_0.mcap",
    "bag_1.mcap",
    "logs/",
    "comparison.html",
    "metadata.yaml",
    "metrics.json",
    "replay.json",
    "report.html",
    "runs/",
    "runs/experiment-NAME-TIME",
    "runs/transition-sequence-TIME/",
    "scenario.yaml",
}
# What the set-up makes.
MADE = {".venv/environment.sh", "build/site", "ros2_ws/install/setup.bash"}
FILE = re.compile(r"[\w.*/-]+\.(?:cff|css|js|json|lock|mcap|md|msg|py|sh|srv|toml|txt|xml|ya?ml)")

# `Class.attribute`, also behind the name of a package, and before arguments or further attributes.
_ATTRIBUTE = re.compile(r"(?<![\w/])([A-Z][a-z]\w*)\.([A-Za-z_]\w*)")

# Each pattern has a class of one letter, so that this file does not hold what it looks for.
LEAKS = {
    "a folder of one machine": r"(?<![\w.$}])/(?:home|root|Users|work|workspaces?|mnt|media)/\w",
    "a package registry": r"p[y]pi\.(?:org|python)|pythonh[o]sted|art[i]factory|j[f]rog|d[e]vpi\b"
    r"|n[e]xus\.|n[p]mjs\.|an[a]conda\.|pr[o]xy\.golang",
    "the address of a registry": r"--(?:extra-)?index[-]url[ =]\S|--find[-]links[ =]\S|/s[i]mple/",
    "a host of one network": r"https?://(?:[\d.]+|[\w-]+|[\w.-]+\.(?:internal|local|lan|corp))[:/]",
}


def text_of(path):
    """Return a document's text."""
    return path.read_text(encoding="utf-8")


def relative(path):
    """Return a path as seen from the root."""
    return path.relative_to(ROOT).as_posix()


def without_fences(text):
    """Return a document without its code blocks."""
    return re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)


def fences(text, *languages):
    """Return the code blocks in one of these languages."""
    blocks = re.findall(r"^```(\w*)\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)
    return [code for language, code in blocks if language in languages]


def commands(text):
    """Return the scripts that a document's code blocks call."""
    lines = "\n".join(fences(text, "sh", "bash")).splitlines()
    return sorted({line.split()[0] for line in lines if line.startswith("./scripts/")})


def named_paths(text):
    """Return the paths that a document names in back quotes."""
    words = re.findall(r"`([^`\s]+)`", without_fences(text))
    top = "|".join(re.escape(path.name) for path in ROOT.iterdir() if path.is_dir())
    inside = re.compile(rf"(?:\./)?(?:{top}|lexstack_\w+)/[\w.*/-]*|[\w./-]+/")
    types = re.compile(r"lexstack_interfaces/(?:(?:msg|srv|action)/)?[A-Z]\w+")
    return sorted(
        {w for w in words if (FILE.fullmatch(w) or inside.fullmatch(w)) and not types.fullmatch(w)}
    )


def exists(path, document):
    """Return whether a named path is there; NAME and FILE stand for any name."""
    if path in RUN_FILES or path in MADE:
        return True
    pattern = re.sub(r"\b[A-Z]{4,}\b(?!\.md)", "*", path).removeprefix("./").rstrip("/")
    bases = [ROOT, document.parent]
    bases += [folder for base in BASES for folder in ROOT.glob(base) if folder.is_dir()]
    if pattern.count("/") == 0 and pattern.endswith(".py"):
        # A module by its name alone, where the text has said where it lies.
        bases += [folder for source in source_folders() for folder in source.rglob("*/")]
    return any(next(base.glob(pattern), None) is not None for base in bases)


@cache
def source_folders():
    """Return the folders with code."""
    return [folder for pattern in SOURCES for folder in ROOT.glob(pattern) if folder.is_dir()]


@cache
def packages():
    """Return the text of all modules of the packages, without the tests."""
    return "\n".join(modules())


@cache
def modules():
    """Return the texts of all modules of the packages, without the tests."""
    files = [file for folder in source_folders()[:-2] for file in sorted(folder.rglob("*.py"))]
    return [text_of(file) for file in files]


@cache
def places_of_classes():
    """Return name -> modules of every class of the packages and of every message type."""
    found = {}
    for package in source_folders()[:-2]:
        for file in sorted(package.rglob("*.py")):
            module = ".".join(file.relative_to(package.parent).with_suffix("").parts)
            for node in ast.parse(text_of(file)).body:
                if isinstance(node, ast.ClassDef):
                    found.setdefault(node.name, []).append(module.removesuffix(".__init__"))
    for kind in ("msg", "srv", "action"):
        for file in (ROOT / "ros2_ws/src/lexstack_interfaces" / kind).glob(f"*.{kind}"):
            found.setdefault(file.stem, []).append(f"lexstack_interfaces.{kind}")
    return found


def attributes_of(cls):
    """Return the names of what a class and its instances have."""
    names = set(dir(cls)) | set(getattr(cls, "__annotations__", {}))
    for base in cls.__mro__:
        if base.__module__.startswith("lexstack"):
            with suppress(TypeError, OSError):  # no source: a message type
                names |= set(re.findall(r"\bself\.(\w+)(?:: [^=\n]+)? = ", inspect.getsource(base)))
    return names


def named_attributes(text):
    """Return the (class, attribute) pairs that a document names as `Class.attribute`."""
    words = re.findall(r"`([^`\n]+)`", without_fences(text))
    return sorted({pair for word in words for pair in _ATTRIBUTE.findall(word)})


def missing_attributes(text):
    """Return what a document names of classes that do not have it, or are not there."""
    missing, own = [], "\n".join(fences(text, "python"))
    for name, attribute in named_attributes(text):
        if f"class {name}" in own and f"def {attribute}(" in own:
            continue  # the page itself shows how to write it
        modules = [importlib.import_module(module) for module in places_of_classes().get(name, ())]
        if not any(attribute in attributes_of(getattr(module, name)) for module in modules):
            missing.append(f"{name}.{attribute}")
    return missing


def anchors(text):
    """Return the anchors of a document's headings, as GitHub makes them."""
    heads = re.findall(r"^#+ (.+)$", without_fences(text), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def broken_links(document, text):
    """Return the relative links of a document that lead nowhere."""
    broken = []
    for link in re.findall(r"\]\(([^)\s]+)\)", without_fences(text)):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (document.parent / path).resolve() if path else document
        if not target.exists() or (anchor and anchor not in anchors(text_of(target))):
            broken.append(link)
    return broken


def leaks(text):
    """Return what a text says of a machine, a network or a registry."""
    found = [(what, re.search(pattern, text)) for what, pattern in LEAKS.items()]
    return [f"{what}: {match.group()}" for what, match in found if match]


def with_constants(name, code):
    """Return a name in code with the constants of its module in place of their names."""
    for constant in re.findall(r"\{([A-Z]+)\}", name):
        value = re.search(rf'^{constant} = "([^"]+)"', code, re.MULTILINE).group(1)
        name = name.replace(f"{{{constant}}}", value)
    return name.replace("{model.name}", "{name}")


def endpoints():
    """Return name -> type of every topic, service and action in the code; {..}: any name."""
    pattern = re.compile(
        r"(?:create_(?:publisher|subscription|service)\(|Server\(\s*(?:self|node),)"  # of an action
        r"\s*(?:self\._)?(\w+),\s*(?:f?\"([^\"]+)\"|(?:relative\()?(\w+))"
    )
    found = {}
    calls = [(module, call) for module in modules() for call in pattern.findall(module)]
    for code, (type_, literal, variable) in calls:
        # A type that may not be installed is imported by name.
        optional = re.search(
            rf"\b{type_} = importlib\.\S+\.(\w+)$|import (\w+) as {type_}\b",
            code,
            re.MULTILINE | re.IGNORECASE,
        )
        kind = optional.group(optional.lastindex) if optional else type_
        defined = re.compile(rf"\b{variable} = f?\"(/[^\"]+)\"")
        where = packages() if variable.isupper() else code  # constants may be another module's
        values = [with_constants(literal, code)] if literal else defined.findall(where)
        names = [name.replace("~", "/sim_bridge") for name in values]
        # Relative ones are those of a run in no namespace.
        found |= {f"/{name.removeprefix('/')}": kind for name in names if name[0] not in ".$"}
    targets = next(code for code in modules() if "OF_FRAMES: dict" in code)
    kinds = re.findall(r'^    "(\w+)": \((\w+), \w+\),$', targets, flags=re.MULTILINE)
    found = {name: kind for name, kind in found.items() if not name.endswith("/{kind}")}
    found |= {f"/NAME/{topic}": kind for topic, kind in kinds}
    return {re.sub(r"\{\w+\}", "NAME", name): kind for name, kind in found.items()}


def table(text):
    """Return name -> type of the page's table of topics and services."""
    rows = re.findall(r"^\| `(/[\w/]+)` \| `(\w+/\w+)` \|", text, flags=re.MULTILINE)
    return {name: kind.split("/")[1] for name, kind in rows}


# ---- commands


@pytest.mark.parametrize("command", commands(text_of(README)))
def test_every_command_of_the_readme_answers_help(command):
    assert os.access(ROOT / command, os.X_OK), command
    done = subprocess.run(
        [ROOT / command, "--help"], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert "usage" in done.stdout.lower()


def test_the_readme_names_the_commands_that_a_user_needs():
    assert {"./scripts/demo", "./scripts/test"} <= set(commands(text_of(README)))


def test_python_beside_a_demo_compiles_and_imports_what_is_there():
    code = re.findall(r"<<'(\w+)'\n(.*?)^\1$", text_of(BY_HAND), flags=re.MULTILINE | re.DOTALL)
    assert code, "the page shows how to switch from Python"
    for _, program in code:
        for node in ast.walk(ast.parse(program)):
            if isinstance(node, ast.ImportFrom) and node.module.startswith("lexstack_interfaces"):
                folder = ROOT / "ros2_ws/src" / node.module.replace(".", "/")
                for name in node.names:
                    assert list(folder.glob(f"{name.name}.*")), name.name


# ---- paths, links, names


@pytest.mark.parametrize("document", DOCUMENTS, ids=relative)
def test_every_path_in_a_document_exists(document):
    missing = [path for path in named_paths(text_of(document)) if not exists(path, document)]
    assert not missing


@pytest.mark.parametrize("document", DOCUMENTS, ids=relative)
def test_every_relative_link_leads_somewhere(document):
    assert not broken_links(document, text_of(document))


def test_every_picture_is_used_and_small():
    used = "".join(map(text_of, DOCUMENTS))
    for picture in (ROOT / "docs/images").iterdir():
        assert f"images/{picture.name}" in used, picture.name
        assert picture.stat().st_size < 400_000, picture.name


def test_every_name_in_the_notation_is_in_the_code():
    words = re.findall(r"`([A-Za-z_][\w.]*)`", text_of(ROOT / "docs/notation.md"))
    assert len(words) > 40
    code = packages()
    names = {part for word in words for part in word.split(".")} - {"pin", "np"}
    assert not {name for name in names if not re.search(rf"\b{re.escape(name)}\b", code)}


@pytest.mark.parametrize("document", DOCUMENTS, ids=relative)
def test_every_attribute_in_a_document_is_one_of_its_class(document):
    assert not missing_attributes(text_of(document))


def test_every_decision_is_in_the_list():
    folder = ROOT / "docs/decisions"
    listed = re.findall(r"\]\((\d{4}-[\w-]+\.md)\)", text_of(folder / "README.md"))
    assert listed == sorted(path.name for path in folder.glob("[0-9]*.md"))


def test_the_page_of_scenarios_names_every_scenario_and_every_key():
    text = text_of(ROOT / "docs/scenarios.md")
    named = set(re.findall(r"`([\w-]+)`", text))
    assert {path.stem for path in (ROOT / "config/scenarios").glob("*.yaml")} <= named
    tables = (ScenarioConfig, TransitionConfig, EventConfig, PlantConfig, PushConfig, StreamConfig)
    tables += (ReferenceTopicsConfig, WayConfig, PathConfig, PostureWayConfig, TwistEventConfig)
    keys = {field.name for table in tables for field in dataclasses.fields(table)}
    assert not keys - named


# ---- contracts


def test_topics_and_services_of_the_page_are_those_of_the_code():
    code, documented = endpoints(), table(text_of(BY_HAND))
    assert len(documented) > 15
    for name, kind in documented.items():
        either = [name, re.sub(r"/robot_[ab]/", "/NAME/", name)]
        assert kind in [code.get(n) for n in either], f"{name} ({kind}) is not in the code"
    missing = {n for n in code if n not in documented}
    assert not missing, "in the code, not in the page"


# ---- leaks


@cache
def own_files():
    """Return the files of the repository: tracked, or new and not ignored."""
    git = ["git", "-C", ROOT, "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        listed = subprocess.run(git, capture_output=True, text=True, check=True).stdout.split("\0")
        files = [ROOT / name for name in listed if name]
    except (OSError, subprocess.CalledProcessError):  # an image has no repository
        made = re.compile(r"/(?:\.\w+|build|install|log|runs|__pycache__|\w+\.egg-info)/")
        files = [f for f in ROOT.rglob("*") if not made.search(f"/{relative(f)}/")]
    return sorted({file for file in files if file.is_file()})


def test_no_file_names_a_machine_or_a_registry():
    assert len(own_files()) > 100
    found = {}
    for file in own_files():
        text = file.read_bytes().decode("utf-8", errors="ignore")
        if "\0" not in text and leaks(text):
            found[relative(file)] = leaks(text)
    assert not found


# ---- these checks can fail


@pytest.mark.parametrize(
    "text",
    [
        "see /#home/someone/ws",
        "cd /#work/main",
        "https://py#pi.org/project/x",
        "--index#-url https://example.org/x",
        "--extra-index#-url=https://example.org",
        "from http:#//10.0.0.7:8080/x",
        "http:#//mirror:3141/root",
        "https:#//cache.corp.internal/wheels",
    ],
)
def test_a_leak_is_seen(text):
    assert not leaks(text), "this file itself is clean"
    assert leaks(text.replace("#", ""))


@pytest.mark.parametrize(
    "text",
    ["https://doi.org/10.1109/x", "/robot_a/chi", "tests/#work/x", "--no-emit-index-url -o lock"],
)
def test_what_is_no_leak_is_left_alone(text):
    assert not leaks(text.replace("#", ""))


@pytest.mark.parametrize(
    "path", ["config/stacks/none.yaml", "lexstack/nothing.py", "nowhere/", "./scripts/dance"]
)
def test_a_wrong_path_is_seen(path):
    assert path in named_paths(f"text `{path}` text")
    assert not exists(path, README)


@pytest.mark.parametrize("path", ["config/robots/NAME.yaml", "lexstack/hqp/", "plant.py"])
def test_a_right_path_is_found(path):
    assert path in named_paths(f"text `{path}` text")
    assert exists(path, README)


@pytest.mark.parametrize(
    "name", ["Solution.colour", "LatchState.chi", "Blend.forget", "Nobody.knows", "Chi.colour"]
)
def test_a_wrong_attribute_is_seen(name):
    assert missing_attributes(f"text `{name}` text") == [name]


@pytest.mark.parametrize(
    "name", ["Solution.chi", "Transition.due", "Lockstep.solver", "GapMotion.rate", "Chi.reason"]
)
def test_a_right_attribute_is_found(name):
    assert named_attributes(f"text `{name}(x)` text")
    assert not missing_attributes(f"text `{name}` text")


def test_a_wrong_link_is_seen():
    text = "[a](docs/none.md) [b](docs/notation.md#no-such-head) [c](#nor-this) [d](https://x.y)"
    assert broken_links(README, text) == [
        "docs/none.md",
        "docs/notation.md#no-such-head",
        "#nor-this",
    ]


def test_a_script_in_a_code_block_is_seen():
    assert commands("```sh\n./scripts/dance --now\n```\n./scripts/not-here") == ["./scripts/dance"]
