"""The peers that a bench measures beside our solver."""

from __future__ import annotations

import numpy as np
import pytest

from lexstack.hqp import HqpProblem
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from lexstack_experiments.hierarchies.peers import STRICT, installed

INF = np.inf


def with_endless_rows():
    """Return a problem whose first level has rows with one end, with two, and with none."""
    rng = np.random.default_rng(1)
    lower = np.array([-0.1, -INF, -INF, -0.2])
    upper = np.array([INF, 0.1, INF, 0.2])
    first = LinearTask("rows", rng.normal(size=(4, 6)), lower, upper)
    second = LinearTask.equality("to", rng.normal(size=(3, 6)), rng.normal(size=3))
    return HqpProblem(((first,), (second,)), Bounds(np.full(6, -1.0), np.full(6, 1.0)))


@pytest.mark.parametrize("peer", installed(STRICT)[0], ids=lambda peer: peer.name)
def test_no_peer_prints_a_word_about_rows_without_ends(peer, capfd):
    """Libraries write past Python: a bench of some thousand solves would flood the terminal."""
    solution = peer.solve(with_endless_rows())
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")
    assert solution.solved
    assert solution.slacks[0] < 1e-6
