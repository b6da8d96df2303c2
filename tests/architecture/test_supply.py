"""What is installed is pinned, hashed and listed; the image runs without privileges."""

import re
import subprocess
import sys

from support.scenario import ROOT
from workspace.ros import lock_entries

LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8")


def test_every_package_is_pinned_with_hashes_and_without_an_address():
    entries = lock_entries(LOCK)
    assert len(entries) > 100
    for name, entry in entries:
        assert re.match(rf"{re.escape(name)}==[\w.!+-]+[ \\\n]", entry), name
        assert re.search(r"--hash=sha256:[0-9a-f]{64}", entry), name
        assert "://" not in entry, name


def test_every_direct_dependency_is_in_the_lock():
    locked = {name for name, _ in lock_entries(LOCK)}
    text = (ROOT / "requirements.txt").read_text(encoding="utf-8")
    for line in text.splitlines():
        name = re.match(r"[A-Za-z0-9_.-]+", line)
        if name:
            assert name.group().lower().replace("_", "-") in locked, line


def test_the_list_of_licences_names_every_locked_package():
    """The whole page is compared where this Python is the one that it was made with."""
    page = (ROOT / "docs" / "licences.md").read_text(encoding="utf-8")
    rows = page.partition("|---|")[2]  # below the table's head
    listed = re.findall(r"^\| ([a-z0-9-]+) \| ([^ |]+) \| [^|]+ \|$", rows, re.M)
    sys.path.insert(0, str(ROOT / "scripts"))
    from licences import page as make
    from licences import version

    wanted = [
        (name, version(entry))
        for name, entry in sorted(lock_entries(LOCK))
        if "sys_platform == 'win32'" not in entry
    ]
    assert listed == wanted
    now = dict(re.findall(r"^\| ([a-z0-9-]+) \| [^|]+ \| ([^|]+) \|$", make(LOCK), re.M))
    then = dict(re.findall(r"^\| ([a-z0-9-]+) \| [^|]+ \| ([^|]+) \|$", page, re.M))
    changed = {
        name: (then[name], now[name])
        for name in then
        if now[name] != then[name] and "not installed" not in now[name]
    }
    assert not changed


def image_steps():
    """Return the steps of the Dockerfile, each a word and the rest of its lines."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8").replace("\\\n", " ")
    return re.findall(r"^([A-Z]+) (.*)$", text, re.M)


def test_the_image_runs_as_an_unprivileged_user():
    steps = image_steps()
    users = [i for i, (word, _) in enumerate(steps) if word == "USER"]
    assert [steps[i][1] for i in users] == ["lexstack"]
    assert not any("setup" in rest for word, rest in steps[: users[0]] if word == "RUN")
    assert steps[-1][0] == "CMD"


def test_an_edit_of_the_sources_does_not_install_the_packages_again():
    """A layer is made anew where what is copied before it has changed."""
    steps = image_steps()
    packages = steps.index(("RUN", "PIP_NO_CACHE_DIR=1 ./scripts/setup --packages"))
    everything = steps.index(("COPY", "--chown=lexstack . ."))
    assert packages < everything
    copied = [
        name for word, rest in steps[:packages] if word == "COPY" for name in rest.split()[1:-1]
    ]
    needed = {"requirements.lock", "scripts/setup", "scripts/setup_workspace.py"}
    assert set(copied) == needed | {"scripts/workspace"}
    assert all((ROOT / name).exists() for name in copied)


def test_the_image_has_what_its_tests_need():
    apt = next(rest for word, rest in image_steps() if word == "RUN" and "apt-get install" in rest)
    assert {"chromium", "iproute2", "g++", "cmake", "make", "python3-venv"} <= set(apt.split())


def test_the_page_makes_the_folder_that_the_image_writes_to():
    """One that docker makes is root's, and the image's account cannot write to it."""
    page = (ROOT / "docs" / "first-run.md").read_text(encoding="utf-8")
    made, run = page.index("mkdir -p runs"), page.index('-v "$PWD/runs:/lexstack/runs"')
    assert made < run
    assert '--user "$(id -u):$(id -g)"' in page[made:run]


def ignored(path):
    """Return whether .dockerignore leaves a path out: itself, or a folder that it lies in."""
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    patterns = [line for line in lines if line and not line.startswith("#")]
    assert not any(set(line) & set("!?\\") for line in patterns), "not read by this test"
    forms = {"**/": "(?:.*/)?", "*": "[^/]*"}
    for pattern in patterns:
        words = re.split(r"(\*\*/|\*|\[[a-z]+\])", pattern)
        form = "".join(
            forms.get(word, word if word[:1] == "[" else re.escape(word)) for word in words
        )
        if re.fullmatch(f"{form}(?:/.*)?", path):
            return True
    return False


def test_nothing_that_a_machine_made_goes_into_the_image_and_all_that_is_ours_does():
    made = (
        ".git/config", ".venv/bin/python", "build/setup.log", "ros2_ws/build/x/y",
        "ros2_ws/install/setup.bash", "ros2_ws/log/latest", "sim_bridge/build/lib/a.py",
        "ros2_ws/src/lexstack/build/lib/a.py", "ros2_ws/src/lexstack_ros/log/x",
        "sim_bridge/lexstack_sim.egg-info/PKG-INFO", "runs/one/bag/a.mcap", "MUJOCO_LOG.TXT",
        "tests/unit/MUJOCO_LOG.TXT", "tests/__pycache__/a.pyc", ".ruff_cache/x", ".hypothesis/x",
        "setup.log", "tests/.pytest_cache/x", "docs/logs/a",
    )  # fmt: skip
    assert [path for path in made if not ignored(path)] == []
    done = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    ours = done.stdout.splitlines() or ["README.md", "ros2_ws/src/lexstack/setup.py"]
    assert [path for path in ours if ignored(path)] == []


def test_the_licences_command_tells_whether_its_page_is_current(tmp_path, monkeypatch, capsys):
    sys.path.insert(0, str(ROOT / "scripts"))
    import licences

    page = tmp_path / "docs" / "licences.md"
    page.parent.mkdir()
    monkeypatch.setattr(licences, "ROOT", tmp_path)
    monkeypatch.setattr(licences, "TARGET", page)
    (tmp_path / "requirements.lock").write_text(LOCK, encoding="utf-8")

    def code(*arguments):
        monkeypatch.setattr(sys, "argv", ["licences.py", *arguments])
        return licences.main()

    assert code("--check") == 1, "there is no page"
    assert code() == 0
    assert "packages" in capsys.readouterr().out
    assert code("--check") == 0
    page.write_text(page.read_text(encoding="utf-8").replace("numpy", "numpie", 1), "utf-8")
    assert code("--check") == 1


def test_the_licences_command_says_of_our_page_what_it_would_write():
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "licences.py", "--check"],
        check=False,
        capture_output=True,
        text=True,
    )
    from licences import page as make

    page = (ROOT / "docs" / "licences.md").read_text(encoding="utf-8")
    assert done.returncode == int(make(LOCK) != page), done.stderr
