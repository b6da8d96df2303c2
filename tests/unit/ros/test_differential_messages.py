"""Messages about a robot on a differential base: q is longer than chi."""

import numpy as np
import pytest

import lexstack
from lexstack.errors import InputError
from lexstack_bag.figures.export import _POSITION, _VELOCITY, _entries
from lexstack_bag.run.columns import StreamBuilder
from lexstack_bag.run.run import PlantStream
from lexstack_interfaces.msg import PlantState
from lexstack_ros.messages.conversions import to_array, to_state
from lexstack_sim.driving import Driving
from support.differential import DT, driven


@pytest.fixture(scope="module")
def team():
    return lexstack.Team((driven("ur10", place="one"), driven("tiago", place="two")), DT)


def message_of(team, **values):
    numbers = {"q": team.nq, "v": team.n, "q_star": team.nq, "command": team.n}
    message = PlantState(robots=list(team.names), tick=3)
    for name, n in numbers.items():
        setattr(message, name, to_array(values.get(name, np.arange(float(n)))))
    return message


def test_a_state_has_positions_of_one_length_and_velocities_of_another(team):
    state = to_state(message_of(team), team)
    assert state.q.shape == state.q_star.shape == (team.nq,) == (20,)
    assert state.v.shape == state.command.shape == (team.n,) == (18,)
    for name, n in (("q", team.n), ("v", team.nq), ("q_star", team.n), ("command", team.nq)):
        with pytest.raises(InputError, match=f"/plant/state: {name}: "):
            to_state(message_of(team, **{name: np.zeros(n)}), team)


def test_a_bag_s_columns_have_these_lengths_and_the_names_of_their_entries(team):
    builder = StreamBuilder(PlantStream, team.n, "first", team.nq)
    builder.add(message_of(team))
    stream = builder.build()
    assert stream.q.shape == stream.q_star.shape == (1, team.nq)
    assert stream.v.shape == stream.command.shape == (1, team.n)
    assert np.isfinite(stream.q).all()
    assert np.isfinite(stream.command).all()
    assert _entries(team, _POSITION)[:3] == [
        ("one", "base_x", "m"), ("one", "base_y", "m"), ("one", "base_yaw", "rad"),
    ]  # fmt: skip
    assert _entries(team, _VELOCITY)[:2] == [("one", "base_v", "m/s"), ("one", "base_w", "rad/s")]
    assert (len(_entries(team, _POSITION)), len(_entries(team, _VELOCITY))) == (team.nq, team.n)


def test_the_plant_s_rates_are_those_of_the_library_and_come_back(team):
    rng, driving = np.random.default_rng(2), Driving(team)
    assert not driving.straight
    for _ in range(10):
        q, chi = rng.normal(size=team.nq), rng.normal(size=team.n)
        expected = np.concatenate(
            [
                robot.rate_matrix(q[at]) @ chi[part]
                for robot, at, part in zip(team.robots, team.q_slices, team.slices, strict=True)
            ]
        )
        rates = driving.rates(q, chi)
        np.testing.assert_allclose(rates, expected, atol=1e-15)
        np.testing.assert_allclose(driving.velocities(q, rates), chi, atol=1e-15)
