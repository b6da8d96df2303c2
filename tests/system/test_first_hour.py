"""The programs that two pages print: beside a running demo, and beside none."""

import dataclasses
import os
import subprocess
import sys
import threading
import time

import pytest

from lexstack_config.resolved import load_scenario
from lexstack_testing.played_run import apart
from support.code_blocks import HEREDOC, all_blocks
from support.scenario import CONFIG

pytestmark = pytest.mark.system
PROGRAMS = {
    block.page: program
    for block in all_blocks()
    if block.language == "sh"
    for _, program in HEREDOC.findall(block.text)
}
UNUSED = "231"  # a domain in which nobody speaks: runs take those up to 100


def start(page, domain=None):
    """Start the program of a page, as its ``./scripts/shell python -`` does."""
    environment = dict(os.environ)
    if domain is not None:
        environment["ROS_DOMAIN_ID"] = domain
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAMS[page]],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_every_page_with_a_program_is_known_here():
    assert set(PROGRAMS) == {"docs/ros-by-hand.md", "docs/htmpc.md"}


def test_in_the_wrong_domain_a_program_ends_with_one_line_that_says_what_to_check():
    """All at the same time: they wait."""
    begun = time.monotonic()
    processes = {page: start(page, UNUSED) for page in PROGRAMS}
    for page, process in processes.items():
        _, errors = process.communicate(timeout=60.0)
        assert process.returncode == 1, page
        assert time.monotonic() - begun < 30.0, page
        lines = [line for line in errors.splitlines() if line]
        assert len(lines) == 1, errors
        assert "ROS_DOMAIN_ID" in lines[0]


class ProgramsDoneError(Exception):
    """All programs have ended."""


@pytest.mark.alone  # the programs wait by the clock for what ticks do
def test_beside_a_demo_the_programs_print_what_the_pages_say(tmp_path):
    found = load_scenario(CONFIG / "scenarios/by-hand.yaml")
    resolved = dataclasses.replace(
        found, scenario=dataclasses.replace(found.scenario, duration=120.0)
    )
    done = {}

    def do():
        for page in ("docs/ros-by-hand.md", "docs/htmpc.md"):
            process = start(page)
            done[page] = (*process.communicate(timeout=60.0), process.returncode)

    worker = threading.Thread(target=do)
    with apart(resolved, tmp_path) as run:

        def watch():
            run.supervisor.check()
            if run.player.tick > 50 and not worker.ident:
                worker.start()
            if worker.ident and not worker.is_alive():
                raise ProgramsDoneError

        with pytest.raises(ProgramsDoneError):
            run.play(watch)
    out, errors, code = done["docs/ros-by-hand.md"]
    assert (code, errors) == (0, "")
    lines = out.splitlines()
    assert lines[0].startswith("transition 1 to 'posture' starts at tick ")
    phases = [line.split()[2] for line in lines if line.split()[1:2] == ["posture"]]
    assert phases == sorted(phases)
    assert phases[-1] == "3"  # it blends
    cancelled = "transition 1 is cancelled; transition 2 to 'track' starts"
    assert any(line.startswith(cancelled) for line in lines)
    assert any(" reach_base 3 " in line for line in lines)
    assert lines[-1].split()[1:4] == ["reach_base", "0", "1.00"]
    out, errors, code = done["docs/htmpc.md"]
    assert (code, errors) == (0, "")
    assert "success=True" in out
    assert "done=2" in out
