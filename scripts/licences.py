"""Writes docs/licences.md: every package of the lock and its licence, as the package tells it.

Run by `./scripts/run python scripts/licences.py` in the environment of the set-up.
"""

from __future__ import annotations

import re
import sys
from importlib import metadata
from pathlib import Path

from workspace.ros import lock_entries

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "docs" / "licences.md"
HEAD = """# Licences

lexstack is under the [Apache License 2.0](../LICENSE). It installs the packages below from
`requirements.lock`; each keeps its own licence. This list is made from the packages' metadata by
`./scripts/run python scripts/licences.py`, and a test compares it. Packages that the metadata says
nothing of are marked: look at their project.

Tools that the set-up installs with apt-get where they are missing (Python, g++, cmake, make, Mesa)
come from the distribution, with its licences.

| package | version | licence |
|---|---|---|
"""
LONGEST = 60  # characters of a licence in the table
SILENT = "not stated in its metadata"
ABSENT = "not installed on this platform"


def licence(name: str) -> str:
    """Return a package's licence in a few words, from what its metadata says."""
    try:
        about = metadata.metadata(name)
    except metadata.PackageNotFoundError:
        return ABSENT
    expression = about.get("License-Expression")
    if expression:
        return brief(expression)
    described = Path(sys.prefix, "share", re.sub("^ros-(jazzy-)?", "", name).replace("-", "_"))
    described /= "package.xml"  # a ROS package says it there
    if described.is_file():
        found = re.findall(r"<license[^>]*>([^<]+)<", described.read_text(encoding="utf-8"))
        return brief("; ".join(dict.fromkeys(text.strip() for text in found)))
    classified = [
        text.rsplit(" :: ", 1)[1]
        for text in about.get_all("Classifier") or []
        if text.startswith("License :: ") and not text.endswith("OSI Approved")
    ]
    return brief("; ".join(dict.fromkeys(classified)) or about.get("License") or SILENT)


def brief(text: str) -> str:
    """Return a licence as a cell of the table: its first line, not long."""
    line = next((line.strip() for line in text.splitlines() if line.strip()), SILENT)
    line = line.replace("|", "/")
    return line if len(line) <= LONGEST else line[: LONGEST - 1] + "…"


def version(entry: str) -> str:
    """Return the version that an entry of the lock pins."""
    return re.split(r"[\s;\\]", entry.split("==", 1)[1], maxsplit=1)[0]


def page(lock: str) -> str:
    """Return the whole page for a lock file's text."""
    rows = [
        f"| {name} | {version(entry)} | {licence(name)} |"
        for name, entry in sorted(lock_entries(lock))
        if "sys_platform == 'win32'" not in entry
    ]
    return HEAD + "\n".join(rows) + "\n"


def main() -> int:
    """Write the page; with --check only tell whether it is current."""
    text = page((ROOT / "requirements.lock").read_text(encoding="utf-8"))
    if "--check" in sys.argv[1:]:
        return 0 if TARGET.exists() and TARGET.read_text(encoding="utf-8") == text else 1
    TARGET.write_text(text, encoding="utf-8")
    print(f"wrote {TARGET.relative_to(ROOT)}: {text.count(chr(10)) - HEAD.count(chr(10))} packages")
    return 0


if __name__ == "__main__":
    sys.exit(main())
