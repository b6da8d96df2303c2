"""A stack that is made while the robots move: asked for, solved, adopted, within the limits."""

from __future__ import annotations

import numpy as np

from lexstack.control import ExactPlant, Lockstep, make_controller, make_stack_solver
from lexstack.tasks import StackConfig, build_stack
from lexstack.transition import Phase, TransitionConfig, TransitionOptions
from support.scenario import home, team


def test_a_new_stack_is_gone_to_smoothly_and_is_known_from_then_on():
    track = build_stack(StackConfig.of_tasks("track", "ee_pose", "velocity_damping"), team())
    added = build_stack(StackConfig.of_tasks("added", "ee_pose", "posture", "base"), team())
    options = TransitionOptions("track", TransitionConfig(0.5), lockstep=True)
    controller = make_controller(team(), {"track": track}, options)
    solver = make_stack_solver(team(), {"track": track})
    run = Lockstep(team(), controller, solver, ExactPlant(home(), team().dt, team()))
    chi, phases = [], []
    for tick in range(200):
        if tick == 20:
            assert not controller.transition.ask("added", 0.0, "", 0).accepted
            solver.learn(added)
            assert controller.transition.ask_new(added, 0.0, "", 0).accepted
        if tick == 120:
            assert controller.transition.ask("track", 0.0, "", 0).accepted
            assert controller.transition.ask("added", 0.0, "", 180).accepted
        command = run.step()
        chi.append(command.chi)
        phases.append((command.transition.to_stack, command.transition.phase))
    steps = np.abs(np.diff(chi, axis=0)) / (team().dt * team().limits.acceleration)
    assert steps.max() <= 1.0 + 1e-6
    assert np.abs(chi[21]).max() < 0.02, "no jump at the trigger: the robots were at rest"
    assert np.abs(chi).max() > 0.02
    for stack in ("added", "track"):
        assert (stack, Phase.ADOPTING) in phases
    assert phases[-1][0] == "added"
