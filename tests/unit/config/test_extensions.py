"""Extensions: modules that a scenario lists bring methods, solvers and tasks by name."""

import importlib
import sys

import numpy as np
import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack.hqp import SOLVERS, make_solver, register_solver
from lexstack.tasks import TASKS, Posture, register_task
from lexstack.transition import METHODS, Transition, TransitionOptions, register_method
from lexstack.types import RobotState
from lexstack_config.checked import checked
from lexstack_config.extensions import load_extensions
from lexstack_config.parts import Parts, build_controller, home_of
from lexstack_config.resolved import ResolvedScenario, load_scenario
from support.scenario import changed
from support.stack_files import folder

pytestmark = pytest.mark.usefixtures("registries")

MINE = """
from lexstack import METHODS, SOLVERS, TASKS, register_method, register_solver, register_task

used = []

def follow(view, latched, alpha):
    used.append(alpha)
    return METHODS["bridge"](view, latched, alpha)

def solver():
    return SOLVERS["daqp"]()

def task(team, robot, parameters, where):
    return TASKS["posture"](team, robot, parameters, where)

register_method("follow", follow)
register_solver("my_solver", solver)
register_task("my_posture", task)
"""
STACK = "name: some\ndescription: d\nlevels: [{tasks: [{type: my_posture}]}]\n"


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Return a function that writes a module of the user's own, which can be imported."""
    monkeypatch.syspath_prepend(tmp_path / "modules")
    (tmp_path / "modules").mkdir()
    names = []

    def write(text, name="my_extension"):
        (tmp_path / "modules" / f"{name}.py").write_text(text, encoding="utf-8")
        importlib.invalidate_caches()
        names.append(name)
        return name

    yield write
    for name in names:
        sys.modules.pop(name, None)


def scenario(tmp_path, **values):
    """Return the default scenario's file with some values replaced, beside the stack ``some``."""
    path = folder(tmp_path, some=STACK)
    data = yaml.safe_load(path.read_text(encoding="utf-8"))
    data["transition"] |= values.pop("transition", {})
    path.write_text(yaml.safe_dump(data | values), encoding="utf-8")
    return path


def test_a_module_of_the_users_own_brings_a_method_a_solver_and_a_task(tmp_path, module):
    name = module(MINE)
    path = scenario(
        tmp_path, extensions=[name], solver="my_solver", transition={"method": "follow"}
    )
    read = checked(load_scenario(path), path.parent.parent)
    resolved = ResolvedScenario.from_yaml(read.to_yaml(), "copy")
    assert resolved.scenario.extensions == (name,)
    parts = Parts.of(resolved)
    controller = build_controller(resolved, parts)
    assert isinstance(parts.stacks["some"].levels[0].tasks[0], Posture)
    assert controller.transition.ask("some", 0.0, "", 1).accepted
    assert controller.transition.ask("track", 0.0, "follow", 9).accepted
    assert not controller.transition.ask("track", 0.0, "jump", 9).accepted
    used = sys.modules[name].used
    state = RobotState.at_rest(home_of(parts.team, resolved))
    for _ in range(80):  # the solver B never answers: the controller solves the new stack itself
        command = controller.tick(state)
        assert np.isfinite(command.chi).all()
        state = state.after(command.chi, parts.dt)
    assert used
    assert used[0] == 0.0


def test_without_the_key_the_names_are_unknown(tmp_path, module):
    module(MINE)
    resolved = load_scenario(scenario(tmp_path))
    more = "extensions of the scenario add others"
    assert Parts.of(resolved).unfit["some"].endswith(f"relative_pose, velocity_damping; {more}")
    for values, text in (
        ({"transition": {"method": "follow"}}, "transition.method: unknown method 'follow'"),
        ({"solver": "my_solver"}, "solver: unknown solver 'my_solver'; known: kernel, daqp"),
    ):
        path = scenario(tmp_path / text[:6], **values)
        with pytest.raises(ConfigurationError) as error:
            load_scenario(path)
        assert str(error.value).startswith(f"{path}: {text}")
        kind = text.split("unknown ")[1].split()[0]
        assert str(error.value).endswith(f"{more}, such as lexstack_experiments.{kind}s")


BAD = {
    "import no_such_module_of_anybody": "ModuleNotFoundError: No module named 'no_such_module",
    "def f(:": "SyntaxError: ",
    "raise ValueError('one\\ntwo')": "ValueError: one two",
    "raise SystemExit('gone')": "SystemExit: gone",
    "raise RuntimeError('x' * 10_000)": "RuntimeError: xxx",
    "import lexstack; lexstack.register_method('bridge', print)": "ConfigurationError: method",
    "import lexstack; lexstack.register_task('a b', print)": "ConfigurationError: task 'a b'",
}


@pytest.mark.parametrize(("text", "message"), BAD.items(), ids=BAD)
def test_a_module_that_cannot_be_imported_is_one_line_with_file_and_key(
    tmp_path, module, text, message
):
    path = scenario(tmp_path, extensions=["json", module(text)])
    for _ in range(2):
        with pytest.raises(ConfigurationError) as error:
            load_scenario(path)
        line = f"{path}: extensions[1]: cannot import 'my_extension': {message}"
        assert str(error.value).startswith(line)
        assert "\n" not in str(error.value)
        assert len(str(error.value)) < len(line) + 300


def test_a_module_that_is_not_there_hinders_only_those_who_need_it():
    """A recorder and an analysis read the scenario; a controller cannot be made of it."""
    text = changed(extensions=("nobody.has.this",)).to_yaml()
    resolved = ResolvedScenario.from_yaml(text, "copy")
    with pytest.raises(ConfigurationError, match=r"^scenario .*: extensions\[0\]: cannot import"):
        Parts.of(resolved)


class Mine(Posture):
    """Inherits what makes it."""


def method(_view, _latched, _alpha):
    raise NotImplementedError


@pytest.mark.parametrize(
    ("register", "known", "own"),
    [
        (register_method, METHODS, "bridge"),
        (register_solver, SOLVERS, "daqp"),
        (register_task, TASKS, "posture"),
    ],
)
def test_a_name_is_taken_once(register, known, own):
    before = known[own]
    with pytest.raises(ConfigurationError, match=f"'{own}' of .*is registered already by lexstack"):
        register(own, method)
    assert known[own] is before
    with pytest.raises(ConfigurationError, match="registered already"):
        register(own, Mine.from_config)
    with pytest.raises(ConfigurationError, match="a name has letters"):
        register("no name", method)
    register("mine", method)
    register("mine", method)  # as when a module is loaded again
    assert known["mine"] is method


def test_a_library_user_is_told_too():
    parts, options = Parts.of(changed()), changed().scenario.transition
    wrong = type(options)(1.0, method="jump")
    with pytest.raises(ConfigurationError, match="unknown method 'jump'; known: bridge"):
        Transition(parts.stacks, None, TransitionOptions("track", wrong), parts.team)
    with pytest.raises(ConfigurationError, match="unknown solver 'mosek'; known: kernel, daqp"):
        make_solver("mosek")
    with pytest.raises(ConfigurationError, match=r"^here: transition\.method: unknown method"):
        load_extensions(changed(transition=wrong).scenario, "here")
