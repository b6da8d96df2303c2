"""The checks of experiment faults find what is wrong, in records that are made here."""

import numpy as np
import pytest

from lexstack.types import PlantStatus
from lexstack_experiments.experiments.fault_checks import (
    first_statement,
    out_of_order,
    outcome,
    peak_acceleration,
    split,
)
from lexstack_experiments.experiments.fault_records import Record, Solved, State, Statement
from support.scenario import team

FOLLOWING, _, BRAKING, PAUSED = PlantStatus

S = 1_000_000_000  # ns
LIMITS = team().limits
N = LIMITS.velocity.size
PLANT, A, B = "sim_bridge@h/1/a", "hqp_controller@h/2/b", "stack_solver@h/3/c"


def state(tick, command=None, status=FOLLOWING, sender=PLANT):
    command = np.zeros(N) if command is None else command
    return State(tick * S // 100, sender, tick, status, np.zeros(N), command)


def chi(tick, beyond=0.0, sender=A, empty=0):
    return Solved(tick * S // 100, sender, tick, np.zeros(N), beyond, empty)


def record(ticks=1000):
    return Record(
        [state(k) for k in range(ticks)],
        [chi(k) for k in range(ticks)],
        [chi(k, sender=B) for k in range(500, ticks)],
    )


EVENT = {
    "case": "kill stack_solver blending",
    "begun": 2 * S,
    "healed": 4 * S,
    "ended": 8 * S,
    "bag": "bag",
    "later": "bag",
    "answers": 0,
    "rejoined": True,
}
LOST = Statement(int(2.1 * S), "local", "the solver lost at tick 210")
SILENT = Statement(5 * S, "hqp_controller", "stack_solver is silent for 3 s")


def judged(given, **changes):
    return outcome({**EVENT, **changes}, given, LIMITS, 0.01)


def test_a_case_that_is_told_and_served_again():
    given = record()
    given.transitions, given.diagnostics = [LOST], [SILENT]
    found = judged(given)
    assert found.detected == pytest.approx(0.1)
    assert found.told == pytest.approx(3.0)
    assert found.recovered == pytest.approx(1.0)
    assert (found.missing, found.reordered, found.beyond, found.away) == ("", 0, 0.0, 0.0)


def test_reasons_that_are_missing_are_named():
    assert judged(record()).missing == "transition, diagnostics"
    given = record()
    given.diagnostics = [SILENT]
    assert judged(given).missing == "transition"
    given.transitions = [Statement(1 * S, "", LOST.text), Statement(3 * S, "", LOST.text)]
    assert judged(given).missing == "transition", "it stood there before"


def test_a_command_out_of_its_box_or_without_one_is_seen():
    given = record()
    given.commands[300] = chi(300, beyond=1e-3)
    assert judged(given).beyond == 1e-3
    given.commands[301] = chi(301, empty=2)
    assert judged(given).beyond == 2.0


def test_a_jump_of_the_command_in_force_is_seen():
    jump = np.zeros(N)
    jump[4] = 3.0 * LIMITS.acceleration[4] * 0.01
    states = [state(0), state(1, jump), state(3)]
    assert peak_acceleration(states, LIMITS.acceleration, 0.01) == pytest.approx(3.0)
    assert peak_acceleration([state(0), state(2, jump)], LIMITS.acceleration, 0.01) == 0.0


def test_what_is_out_of_order_is_counted():
    assert out_of_order([chi(k) for k in (1, 2, 5, 6)]) == 0
    assert out_of_order([chi(k) for k in (1, 2, 2, 1, 3)]) == 2
    assert out_of_order([state(0, status=PAUSED)] * 3 + [state(0), state(1)]) == 0
    assert out_of_order([state(0), state(0)]) == 1
    other = [state(5), state(0, sender="sim_bridge@h/9/z")]
    assert out_of_order(other) == 0
    again = [chi(8), Solved(9 * S, A, 0, np.zeros(N), 0.0, 0)]
    assert (out_of_order(again), out_of_order(again, [8 * S])) == (1, 0)


def test_a_plant_that_brakes_is_a_sign_and_its_time_is_counted():
    given = record()
    for k in range(250, 300):
        given.states[k] = state(k, status=BRAKING)
    found = judged(given)
    assert found.detected == pytest.approx(0.5)
    assert found.away == pytest.approx(0.5)


def test_only_what_matches_in_its_time_counts():
    told = [
        Statement(1, "a", "the solver lost"),
        Statement(5, "a", "the solver is back"),
        Statement(7, "a", "robot C"),
    ]
    assert first_statement(told, (4, 9), "the solver").at == 5
    assert first_statement(told, (6, 9), "the solver") is None
    assert first_statement(told, (6, 9), "") is None


def test_the_name_of_a_case_is_taken_apart():
    assert split("kill stack_solver blending") == ("kill", "stack_solver", "blending")
    assert split("message of the future blending") == ("message", "of the future", "blending")
