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


def test_the_image_runs_as_an_unprivileged_user():
    lines = (ROOT / "Dockerfile").read_text(encoding="utf-8").splitlines()
    words = [line.split()[0] for line in lines if re.match(r"[A-Z]+ ", line)]
    users = [line.split()[1] for line in lines if line.startswith("USER ")]
    assert users == ["lexstack"]
    assert words.index("USER") > max(i for i, word in enumerate(words) if word == "RUN")
    assert words[-1] == "CMD"


def test_the_licences_command_tells_whether_its_page_is_current():
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "licences.py", "--check"],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode in (0, 1), done.stderr
