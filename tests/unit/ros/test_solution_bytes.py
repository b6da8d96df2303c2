"""The solver's chi and plans as bytes: what the generated messages hold."""

from __future__ import annotations

import numpy as np
from rclpy.serialization import deserialize_message
from trajectory_msgs.msg import JointTrajectory

from lexstack.mpc import Plan
from lexstack_interfaces.msg import Chi
from lexstack_ros.messages.conversions import to_array, to_time
from lexstack_ros.messages.plan_bytes import PlanBytes
from lexstack_ros.messages.plans import plan_message
from lexstack_ros.messages.solution_bytes import SolutionBytes


def test_solutions_of_several_stacks_take_turns():
    rng, make = np.random.default_rng(0), SolutionBytes("me")
    for k in range(60):
        robots, n = (["one", "two"], 20) if k % 2 else (["two"], 10)
        words = {"stack": f"stack_{k % 3}", "reason": "" if k % 7 else "near a singularity"}
        vectors = {name: rng.normal(size=n) for name in ("chi", "lower", "upper")}
        vectors["slacks"] = rng.normal(size=k % 4)
        numbers = {"tick": k, "transition_id": k % 5, "references": 3, "status": k % 3}
        numbers |= {"empty_bounds": k, "solve_time": 1e-3 * k}
        expected = Chi(sender="me", robots=robots, **words, **numbers)
        expected.header.frame_id, expected.header.stamp = "world", to_time(0.01 * k)
        for name, vector in vectors.items():
            setattr(expected, name, to_array(vector))
        data = make(0.01 * k, robots, words, vectors, numbers)
        assert deserialize_message(data, Chi) == expected


def test_plans_of_several_robots_take_turns():
    rng, make = np.random.default_rng(0), PlanBytes()
    for k in range(20):
        n = (3, 5, 8)[k % 3]
        names = [f"r/{i}" for i in range(n)]
        plan = plan_of(rng, n, 6 + k % 2, 0.05 * k)
        assert deserialize_message(make(plan, names), JointTrajectory) == plan_message(plan, names)


def plan_of(rng: np.random.Generator, n: int, stages: int, stamp: float) -> Plan:
    q, v, u = (rng.normal(size=(rows, n)) for rows in (stages + 1, stages + 1, stages))
    return Plan(stamp, 0.1, q, v, u, (), (), (), 0.0)
