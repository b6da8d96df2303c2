"""The compiled code of a tick: loaded in the set-up, and never compiled after it."""

import importlib
import os
import re
import subprocess
import sys
from pathlib import Path

import lexstack
from lexstack import compiled
from lexstack.control.kernels import KERNELS
from lexstack.transition import TransitionConfig
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from support.scenario import changed

SOURCES = Path(lexstack.__file__).parent
USED = re.compile(r'"(lexstack\.[a-z_.]+\.kernel\.[a-z_]+)"')

TICKS = """
from numba.core import event
from lexstack.transition import TransitionConfig
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from support.scenario import changed
scenario = changed(events=(), transition=TransitionConfig(duration=0.05, method="bridge_jerk"))
run = Loop(scenario)
run.plant = IdealPlant(scenario, run.parts.team)
run.controller.transition.ask("reach_base", 0.0, "", 3)
with event.install_recorder("numba:compile") as compiled:
    for _ in range(20):
        run.step()
print(len(compiled.buffer), run.record.commands[-1].stack)
"""


def test_all_that_a_tick_uses_is_loaded_in_the_set_up():
    used = {
        name
        for path in SOURCES.rglob("*.py")
        if "mpc" not in path.parts and path.name != "kernels.py"
        for name in USED.findall(path.read_text(encoding="utf-8"))
    }
    assert used == set(KERNELS)
    run = Loop(changed(events=(), transition=TransitionConfig(duration=0.1)))
    assert all(compiled.kernel(name) is not None for name in KERNELS)
    assert run.controller.transition.stack


def test_no_tick_compiles_anything():
    # A process of its own: nothing that other tests have called is there already.
    done = subprocess.run(
        [sys.executable, "-c", TICKS],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    assert done.stdout.split() == ["0", "reach_base"]


def test_every_entry_has_one_signature():
    for name in KERNELS:
        module = importlib.import_module(name)
        entries = [
            value for value in vars(module).values() if getattr(value, "_can_compile", 1) == 0
        ]
        assert entries, name
        assert all(len(entry.signatures) == 1 for entry in entries)


def test_without_kernels_a_run_has_the_same_bits(monkeypatch):
    with_them = _commands()
    monkeypatch.setattr(compiled, "_LOADED", {})
    monkeypatch.setattr(compiled, "available", lambda: False)
    without = _commands()
    assert [chi.tobytes() for chi in with_them] == [chi.tobytes() for chi in without]


def _commands():
    """Return the commands of a run with a switch, with jerk limits during it."""
    scenario = changed(events=(), transition=TransitionConfig(duration=0.1, method="bridge_jerk"))
    run = Loop(scenario)
    run.plant = IdealPlant(scenario, run.parts.team)
    run.controller.transition.ask("reach_base", 0.0, "", 3)
    for _ in range(40):
        run.step()
    return [command.chi for command in run.record.commands]
