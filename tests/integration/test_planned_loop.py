"""Sequences in one process: the controller keeps its limits whatever becomes of the plans."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from lexstack.transition import Source
from lexstack_config.resolved import load_scenario
from lexstack_experiments.ideal import IdealPlant
from support.planned_loop import PlannedLoop
from support.scenario import CONFIG

MINE = slice(0, 10)  # the controller's own joints; the other robot does something else
BLEND = 100  # ticks


@cache
def resolved(duration):
    found = load_scenario(CONFIG / "scenarios/deliver-one.yaml")
    scenario = dataclasses.replace(found.scenario, duration=duration)
    return dataclasses.replace(found, scenario=scenario)


def run(duration, link=lambda plan: plan):
    """Return the loop after a run, chi tick by tick, and its acceleration over the limit."""
    made = PlannedLoop(resolved(duration))
    made.plant = IdealPlant(made.resolved, made.parts.team)
    made.plan_link = link
    record = made.run()
    chi = np.array([command.chi for command in record.commands])
    before = np.vstack((record.states[0].command, chi[:-1]))
    limits = made.parts.team.limits.acceleration
    return made, chi, np.abs(chi - before) / (0.01 * limits)


def sources(made):
    """Return by tick whom the channel of robot A follows."""
    told = [next(t for t in c.transitions if "robot_a" in t.robots) for c in made.record.commands]
    return [each.source for each in told], [each.reason for each in told]


def roughness(chi, tick):
    """Return how much the acceleration changes from tick to tick, over its limit, rms."""
    limits = resolved(8.0).robots["panda_summit"]
    bounds = np.array([*limits.base.acceleration, *limits.arm.acceleration])
    acceleration = np.diff(chi[tick : tick + 50, MINE], axis=0) / (0.01 * bounds)
    return float(np.sqrt((np.diff(acceleration, axis=0) ** 2).mean()))


def test_a_follows_to_the_bit_once_the_blend_is_over():
    made, chi, ratio = run(8.0)
    progress = made.progress("deliver")
    assert progress[-1].sequence.done
    assert ratio.max() <= 1.0 + 1e-6
    plans = {round(p.plan.stamp / 0.01): p.plan for p in progress}
    for tick in range(100 + BLEND + 5, max(plans)):
        plan = plans[tick - tick % 5]
        wanted = plan.sample(0.01 * (tick + 1))[1]
        np.testing.assert_allclose(chi[tick][MINE], wanted, atol=1e-6)
    assert roughness(chi, 100) < 0.15, "while the controller blends in"


@pytest.mark.parametrize(("first", "last"), [(130, 260), (205, 206), (220, 420)])
def test_a_loss_brings_a_to_rest_and_the_return_takes_it_on(first, last):
    def link(plan):
        return None if first <= plan.tick < last else plan

    made, chi, ratio = run(12.0, link)
    assert ratio.max() <= 1.0 + 1e-6
    who, why = sources(made)
    lost = -(-first // 5) * 5  # the first plan that does not come
    assert f"the MPC lost at tick {lost}" in why[lost]
    assert who[lost - 1] is Source.HTMPC
    assert who[lost] is not Source.HTMPC
    back = -(-last // 5) * 5
    assert who[back] is Source.HTMPC
    assert "the MPC is back" in why[back]
    if back > lost + BLEND:
        assert np.abs(chi[back - 1][MINE]).max() < 1e-3
    assert roughness(chi, back) < 0.12, "no gap comes back with every plan"
    assert made.progress("deliver")[-1].sequence.done


def test_plans_at_random_never_lead_beyond_the_limits():
    rng = np.random.default_rng(0)

    def link(plan):
        """Lose a plan, or hand on what nobody planned."""
        kind = rng.integers(4)
        noise = rng.normal(scale=3.0, size=plan.velocities.shape)
        return [None, plan, dataclasses.replace(plan, velocities=noise), plan][kind]

    _, chi, ratio = run(6.0, link)
    assert np.isfinite(chi).all()
    assert ratio.max() <= 1.0 + 1e-6


def test_a_held_tool_stays_while_the_base_goes_on_and_targets_move():
    made = PlannedLoop(load_scenario(CONFIG / "scenarios/reactivity.yaml"))
    made.run()
    progress = made.progress("deliver")
    assert progress[-1].sequence.done
    stamps = np.array([p.plan.stamp for p in progress])
    firsts = np.array([p.sequence.first for p in progress])
    held = (stamps > 4.5) & (firsts == 1)
    assert stamps[held].max() == pytest.approx(15.95), "until its release at 16 s"
    off = np.array([p.errors[0] for p in progress])[held]
    assert off.mean() < 0.002
    assert off.max() < 0.015, "while the base swings to the next target's new place"
    bases = np.array([p.plan.q[0, :2] for p in progress])
    near = np.linalg.norm(bases - np.array([3.5, 1.5]), axis=1)
    assert near[stamps == 16.0] < 0.12, "there as far as the arm lets it"
    state = made.record.states[-1]
    tool = progress[-1].sequence.tasks[-1].points[-1]
    assert tool == (4.2, 0.9, 1.3), "where the target has jumped to"
    assert progress[-1].errors[0] < 0.005
    assert state.stamp > stamps[-1] + 5.0
