"""The distance task: its rows, and that whoever keeps them keeps the distance."""

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from lexstack.errors import ConfigurationError
from lexstack.hqp import HqpProblem, make_solver
from lexstack.limits import viable_bounds
from lexstack.references import References
from lexstack.robots import ObstacleConfig, Obstacles, Pose, RobotModel, Team
from lexstack.tasks import TASKS, CollisionAvoidance, CollisionAvoidanceParameters
from lexstack.tasks.collision_avoidance import damped_speed
from lexstack.transition.bridge import latch
from lexstack_experiments.solvers import lexicographic_oracle
from support.scenario import home, random_q, state_at, team

DT = 0.01
STEP = 1e-6
FAR = 50.0  # m, an influence that nothing is beyond
EVERY = 10_000  # rows: all pairs
SEEDS = st.integers(0, 2**32 - 1)
PROPERTY = settings(max_examples=150, derandomize=True, deadline=None)


def team_with(**obstacles):
    return Team(team().robots, DT, Obstacles(obstacles))


def some_obstacles(rng, count=3):
    """Return a team with obstacles around both robots, moving at up to 1 m/s."""
    return team_with(
        **{
            f"o{i}": ObstacleConfig(
                tuple(rng.uniform([-4.0, -4.0, 0.0], [4.0, 4.0, 2.0])),
                rng.uniform(0.05, 0.3),
                velocity=tuple(rng.uniform(-0.5, 0.5, 3)),
                swing=tuple(rng.uniform(-0.3, 0.3, 3)),
                period=rng.uniform(2.0, 5.0),
            )
            for i in range(count)
        }
    )


def task_of(a_team, robot=0, **parameters):
    return TASKS["collision_avoidance"](a_team, robot, parameters, "here")


def rooms(a_team, q, stamp, robot=0, others=(), margin=0.05):
    """Return the room of every pair, straight from its definition, in the task's order."""
    spheres = a_team.spheres(q)
    others = np.isin(spheres.owners, others)
    points = np.concatenate([a_team.obstacles.at(stamp), spheres.centers[others]])
    radii = np.concatenate([a_team.obstacles.radii, spheres.radii[others]])
    own = spheres.owners == robot
    between = np.linalg.norm(spheres.centers[own, None] - points, axis=2)
    return (between - spheres.radii[own, None] - radii - margin).ravel()


# ---- the law


@PROPERTY
@given(
    room=st.floats(0.0, 5.0),
    deceleration=st.floats(0.01, 20.0),
    gain=st.floats(0.1, 100.0),
    below=st.floats(0.0, 1.0),
)
def test_whoever_keeps_the_speed_can_brake_to_keep_it_again(room, deceleration, gain, below):
    """Moving at w(r) or slower, for one tick, needs at most a dt less speed at the next."""
    a = np.array([deceleration])
    speed = damped_speed(np.array([room]), a, gain, DT)[0]
    after = damped_speed(np.array([room - DT * speed * below]), a, gain, DT)[0]
    assert after >= speed * below - deceleration * DT - 1e-12
    assert room - DT * speed >= -1e-15, "it never goes past the margin"


@PROPERTY
@given(
    rooms=st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0)),
    deceleration=st.floats(0.0, 20.0),
    gain=st.floats(0.1, 100.0),
)
def test_the_speed_is_odd_and_increasing_and_damped(rooms, deceleration, gain):
    less, more = sorted(rooms)
    a = np.full(3, deceleration)
    slow, fast, back = damped_speed(np.array([less, more, -more]), a, gain, DT)
    assert slow <= fast + 1e-12
    assert back == -fast
    assert abs(fast) <= gain * abs(more) + 1e-12
    # Continuous braking is never slower than the law, which must stop in whole ticks.
    assert abs(fast) <= np.sqrt((deceleration / gain) ** 2 + 2.0 * deceleration * abs(more)) + 1e-9


# ---- the rows


@pytest.mark.parametrize("seed", range(20))
def test_the_rows_are_how_fast_the_distances_change(seed):
    """Against differences of distances, obstacles and both robots in motion, floor included."""
    rng = np.random.default_rng(seed)
    a_team, q = some_obstacles(rng), random_q(rng)
    chi, stamp = rng.normal(size=a_team.n), rng.uniform(0.0, 10.0)
    task = task_of(a_team, robots=["robot_b"], influence=FAR, rows=EVERY, gain=1.0)
    state = dataclasses.replace(state_at(q), stamp=stamp)
    linear = task.linearise(a_team.kinematics(state), None)
    ahead, behind = (
        rooms(a_team, q + sign * STEP * chi, stamp + sign * STEP, others=(1,))
        for sign in (1.0, -1.0)
    )
    speed = (ahead - behind) / (2.0 * STEP)
    able = np.minimum(1.0, 0.5 * np.abs(linear.matrix) @ a_team.limits.acceleration)
    allowed = damped_speed(rooms(a_team, q, stamp, others=(1,)), able, 1.0, DT)
    # A chi - lower = (speed of the distance) + w(r); the mean over the tick instead of the instant.
    np.testing.assert_allclose(linear.matrix @ chi - linear.lower, speed + allowed, atol=2e-2)
    still = Team(a_team.robots, DT, Obstacles({}))
    alone = task_of(still, robots=["robot_b"], influence=FAR, rows=EVERY, gain=1.0)
    linear = alone.linearise(still.kinematics(state), None)
    ahead, behind = (rooms(still, q + sign * STEP * chi, 0.0, others=(1,)) for sign in (1.0, -1.0))
    np.testing.assert_allclose(linear.matrix @ chi, (ahead - behind) / (2.0 * STEP), atol=1e-6)
    assert np.isinf(linear.upper).all()


@pytest.mark.parametrize("seed", range(10))
def test_the_arm_keeps_off_the_floor_and_the_platform_stands_on_it(seed):
    rng = np.random.default_rng(seed)
    q, chi = random_q(rng), rng.normal(size=20)
    plain = team()
    task = task_of(plain, ground=True, influence=FAR, rows=EVERY, margin=0.0, gain=1.0)
    linear = task.linearise(plain.kinematics(state_at(q)), None)
    spheres = plain.spheres(q)
    own = np.flatnonzero(spheres.owners == 0)
    on_arm = spheres.moved_by[own, 3:].any(axis=1)
    assert on_arm.sum() == 17
    np.testing.assert_array_equal(np.isfinite(linear.lower), on_arm)
    ahead, behind = (plain.spheres(q + sign * STEP * chi).centers[own, 2] for sign in (1.0, -1.0))
    rising = (ahead - behind)[on_arm] / (2.0 * STEP)
    np.testing.assert_allclose((linear.matrix @ chi)[on_arm], rising, atol=1e-5)
    room = (spheres.centers[own, 2] - spheres.radii[own])[on_arm]
    able = np.minimum(1.0, 0.5 * np.abs(linear.matrix[on_arm]) @ plain.limits.acceleration)
    np.testing.assert_allclose(linear.lower[on_arm], -damped_speed(room, able, 1.0, DT), atol=1e-4)


@pytest.mark.parametrize("seed", range(10))
def test_links_that_can_meet_keep_apart(seed):
    rng = np.random.default_rng(seed)
    q, chi = random_q(rng), rng.normal(size=20)
    plain = team()
    task = task_of(plain, itself=True, influence=FAR, rows=EVERY)
    linear = task.linearise(plain.kinematics(state_at(q)), None)
    assert task.robots == (0,)
    assert not linear.matrix[:, 10:].any()
    asked = np.isfinite(linear.lower).reshape(24, 24)
    depth = plain.robots[0].spheres.moved_by.sum(axis=1)  # joints that move the sphere
    np.testing.assert_array_equal(asked, depth[:, None] - depth >= 4)
    ahead, now, behind = (
        rooms(plain, q + h * chi, 0.0, others=(0,)).reshape(24, 24) for h in (STEP, 0.0, -STEP)
    )
    speed = (linear.matrix @ chi).reshape(24, 24)
    np.testing.assert_allclose(speed[asked], ((ahead - behind) / (2.0 * STEP))[asked], atol=1e-6)
    able = np.minimum(1.0, 0.5 * np.abs(linear.matrix) @ plain.limits.acceleration)
    allowed = damped_speed(now.ravel(), able, 5.0, DT).reshape(24, 24)
    np.testing.assert_allclose(linear.lower.reshape(24, 24)[asked], -allowed[asked], atol=1e-9)


def test_an_arm_that_is_sent_into_its_own_platform_stops_above_it():
    """The reference of the tool lies inside the chassis."""
    q = home()
    tools = team().tools(q)
    goals = References(
        (Pose(np.array([0.25, 0.0, 0.35]), tools[0].rotation), tools[1]),
        (np.zeros(3), np.zeros(3)),
    )
    least = {}
    for itself in (False, True):
        told = closed_loop(team(), q, goals, 4.0, itself=itself)
        least[itself] = told[:, 0].min()
    assert least[False] < 0.0
    assert least[True] >= 0.05 - 2e-3


@pytest.mark.parametrize("seed", range(10))
def test_the_nearest_pairs_become_rows_in_a_fixed_order(seed):
    rng = np.random.default_rng(seed)
    a_team, q = some_obstacles(rng), random_q(rng)
    kinematics = a_team.kinematics(state_at(q))
    all_rows = task_of(a_team, influence=FAR, rows=EVERY).linearise(kinematics, None)
    few = task_of(a_team, influence=FAR, rows=6).linearise(kinematics, None)
    chosen = np.sort(np.argsort(rooms(a_team, q, 0.0))[:6])
    np.testing.assert_array_equal(few.matrix, all_rows.matrix[chosen])
    np.testing.assert_array_equal(few.lower, all_rows.lower[chosen])


@pytest.mark.parametrize("seed", range(10))
def test_pairs_beyond_the_influence_ask_for_nothing(seed):
    rng = np.random.default_rng(seed)
    a_team, q = some_obstacles(rng), random_q(rng)
    room = rooms(a_team, q, 0.0)
    influence = float(np.median(room)) + 0.05
    assume_positive = max(influence, 0.06)
    task = task_of(a_team, influence=assume_positive, rows=EVERY)
    linear = task.linearise(a_team.kinematics(state_at(q)), None)
    np.testing.assert_array_equal(np.isneginf(linear.lower), room > assume_positive - 0.05)
    assert linear.matrix.shape == (room.size, a_team.n), "the number of rows never changes"


def test_out_of_everything_s_reach_the_rows_ask_for_nothing():
    a_team = team_with(post=ObstacleConfig((90.0, 0.0, 0.0), 0.1))
    linear = task_of(a_team, rows=5).linearise(a_team.kinematics(state_at(home())), None)
    assert linear.matrix.shape == (5, 20)
    assert not linear.matrix.any()
    assert not linear.lower.any()
    assert linear.lower is linear.upper, "no inequality: the solver is quicker without"
    with pytest.raises(ValueError, match="read-only"):
        linear.matrix[0, 0] = 1.0


def test_without_anything_to_keep_away_from_there_are_no_rows():
    linear = task_of(team()).linearise(team().kinematics(state_at(home())), None)
    assert linear.matrix.shape == (0, 20)


def test_only_what_is_named_counts():
    a_team = team_with(
        near=ObstacleConfig((0.7, 0.0, 0.3), 0.1), far=ObstacleConfig((-3.0, 0.0, 0.3), 0.1)
    )
    kinematics = a_team.kinematics(state_at(home()))
    both = task_of(a_team, rows=EVERY, influence=FAR).linearise(kinematics, None)
    one = task_of(a_team, rows=EVERY, influence=FAR, obstacles=["far"]).linearise(kinematics, None)
    np.testing.assert_array_equal(one.matrix, both.matrix[1::2])
    assert not one.matrix[:, 10:].any()
    none = task_of(a_team, obstacles=[], robots=["robot_b"], rows=EVERY, influence=FAR)
    assert none.linearise(kinematics, None).matrix[:, 10:].any(), "the other robot gives way too"
    assert none.robots == (0, 1)
    assert task_of(a_team, 1).robots == (1,)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"margin": -0.1}, "here: margin: must be finite and >= 0"),
        ({"influence": 0.05}, "here: influence: must be > margin = 0.05, got 0.05"),
        ({"deceleration": 0.0}, "here: deceleration: must be finite and > 0"),
        ({"gain": 101.0}, "here: gain: must be <= 100 1/s, one over the control period, got 101"),
        ({"rows": 0}, "here: rows: must be > 0, got 0"),
        ({"obstacles": ["ball"]}, "here: obstacles: unknown obstacle 'ball'; known: post, wall"),
        ({"robots": ["robot_c"]}, "here: robots: unknown robot 'robot_c'; known: robot_a, robot_b"),
        ({"robots": ["robot_a"]}, "here: robots: 'robot_a' is the task's own robot"),
    ],
)
def test_a_wrong_distance_is_refused(parameters, message):
    post, wall = ObstacleConfig((5.0, 0.0, 0.0), 0.1), ObstacleConfig((9.0, 0.0, 0.0), 0.1)
    with pytest.raises(ConfigurationError, match=message):
        task_of(team_with(post=post, wall=wall), **parameters)


def test_a_scenario_without_obstacles_says_so():
    with pytest.raises(ConfigurationError, match="unknown obstacle 'ball'; known: none"):
        task_of(team(), obstacles=["ball"])


def test_centers_that_coincide_give_numbers():
    spheres = team().spheres(home())
    a_team = team_with(inside=ObstacleConfig(tuple(spheres.centers[0]), 0.1))
    linear = task_of(a_team).linearise(a_team.kinematics(state_at(home())), None)
    assert np.isfinite(linear.matrix).all()
    assert not np.isnan(linear.lower).any()


# ---- feasible within the acceleration box, or relaxed


@pytest.fixture(scope="module")
def single():
    """Return one robot for each of its spheres, which has that sphere alone."""
    config = team().robots[0].config
    return [
        RobotModel("robot_a", dataclasses.replace(config, spheres=(sphere,)))
        for sphere in config.spheres
    ]


@given(seed=SEEDS)
@settings(parent=PROPERTY)
def test_a_row_that_is_kept_can_be_kept_at_the_next_tick(single, seed):
    """From any state that keeps it, the acceleration box holds a chi that keeps it again."""
    rng = np.random.default_rng(seed)
    robot = single[rng.integers(len(single))]
    q = random_q(rng)[:10]
    alone = Team((robot,), DT)
    spheres = alone.spheres(q)
    toward = rng.normal(size=3)
    toward /= np.linalg.norm(toward)
    room, speed = rng.uniform(0.0, 0.5), rng.uniform(0.0, 0.5)
    center = spheres.centers[0] - toward * (spheres.radii[0] + 0.15 + room)
    moving = rng.normal(size=3)
    moving *= speed / np.linalg.norm(moving)
    ball = ObstacleConfig(tuple(center), 0.1, velocity=tuple(moving))
    a_team = Team((robot,), DT, Obstacles({"ball": ball}))
    task = CollisionAvoidance(
        a_team, 0, CollisionAvoidanceParameters(influence=FAR, deceleration=1.0)
    )
    chi = rng.uniform(-0.5, 0.5, 10) * a_team.limits.velocity
    row = task.linearise(a_team.kinematics(state_at(q, chi)), None)
    short = row.lower[0] - row.matrix[0] @ chi
    if short > 0.0:
        chi += row.matrix[0] * short / (row.matrix[0] @ row.matrix[0])
    assume(bool((np.abs(chi) <= 0.9 * a_team.limits.velocity).all()))
    after = state_at(q + DT * chi, chi, tick=1)
    row = task.linearise(a_team.kinematics(after), None)
    box = viable_bounds(after.q_star, _unlimited(a_team), DT, chi)
    best = np.maximum(row.matrix[0] * box.lower, row.matrix[0] * box.upper).sum()
    assert best >= row.lower[0]


def _unlimited(a_team):
    """Return the limits without those of position: the claim is about acceleration."""
    free = np.full(a_team.n, np.inf)
    return dataclasses.replace(a_team.limits, position_lower=-free, position_upper=free)


@pytest.mark.parametrize("seed", range(25))
def test_what_cannot_be_kept_is_relaxed_as_little_as_can_be(seed):
    """From random states, deep inside obstacles as well, against bounded least squares."""
    rng = np.random.default_rng(seed)
    a_team, q = some_obstacles(rng, 2), random_q(rng)
    chi = rng.uniform(-0.5, 0.5, 20) * a_team.limits.velocity
    state = state_at(q, chi)
    kinematics = a_team.kinematics(state)
    tasks = [task_of(a_team, 0, robots=["robot_b"], rows=4, influence=2.0), task_of(a_team, 1)]
    level = tuple(task.linearise(kinematics, None) for task in tasks)
    follow = TASKS["velocity_damping"](a_team, 0, {}, "here").linearise(kinematics, None)
    box = viable_bounds(q, a_team.limits, DT, chi)
    problem = HqpProblem((level, (follow,)), box)
    solution = make_solver("daqp").solve(problem)
    assert solution.solved, solution.reason
    assert (solution.chi >= box.lower - 1e-9).all()
    assert (solution.chi <= box.upper + 1e-9).all()
    (best,) = lexicographic_oracle(HqpProblem((level,), box))
    assert solution.slacks[0] == pytest.approx(best.optimum, abs=1e-6)


def test_a_transition_bridges_no_distance():
    """What level 1 lacks at the trigger fades out, but for inequalities: they hold at once."""
    a_team = team_with(post=ObstacleConfig((0.75, 0.0, 0.3), 0.1))
    kinematics = a_team.kinematics(state_at(home()))
    goals = References(a_team.tools(home()), (np.zeros(3), np.zeros(3)))
    level = tuple(
        TASKS[kind](a_team, 0, {}, "here").linearise(kinematics, goals)
        for kind in ("collision_avoidance", "ee_pose")
    )
    command = np.zeros(20)
    command[0] = 2.0
    assert level[0].residual(command).any()
    bridge = latch(command, np.zeros(20), level, level_goes_on=False)
    distances, poses = bridge.epsilon
    assert not distances.any()
    np.testing.assert_array_equal(poses, level[1].residual(command))


# ---- closed loop: an ideal plant that does what it is told


def closed_loop(a_team, q, goals, seconds, robots=(), itself=None):
    """Return the least distance between surfaces in each tick, and level 1's slack.

    ``itself``: whether the controller keeps away from itself; None: that is not looked at.
    """
    apart = a_team.robots[0].spheres.moved_by.sum(axis=1)
    apart = (apart[:, None] - apart >= 4).ravel()
    level = [
        [task_of(a_team, 0, robots=robots, itself=bool(itself)), task_of(a_team, 1)],
        [TASKS["ee_pose"](a_team, i, {}, "here") for i in (0, 1)],
        [TASKS["velocity_damping"](a_team, i, {}, "here") for i in (0, 1)],
    ]
    others = tuple(a_team.index(name) for name in robots)
    solver, warm, chi, told = make_solver("daqp"), None, np.zeros(a_team.n), []
    for tick in range(round(seconds / DT)):
        state = state_at(q, chi, tick)
        kinematics = a_team.kinematics(state)
        levels = tuple(tuple(t.linearise(kinematics, goals) for t in tasks) for tasks in level)
        warm = solver.solve(HqpProblem(levels, viable_bounds(q, a_team.limits, DT, chi)), warm)
        assert warm.solved, warm.reason
        chi = warm.chi
        q = q + DT * chi
        stamp = (tick + 1) * DT
        near = min(
            rooms(a_team, q, stamp, robot, others if robot == 0 else (), margin=0.0).min(
                initial=np.inf
            )
            for robot in (0, 1)
        )
        if itself is not None:
            near = min(near, rooms(a_team, q, stamp, 0, (0,), margin=0.0)[apart].min())
        told.append((near, warm.slacks[0]))
    return np.array(told)


def far_goals(rng, q):
    """Return references up to 1.5 m from the tools, in any direction."""
    poses = [
        Pose(tool.position + rng.uniform([-1.5, -1.5, -0.3], [1.5, 1.5, 0.3]), tool.rotation)
        for tool in team().tools(q)
    ]
    return References(tuple(poses), (np.zeros(3), np.zeros(3)))


@pytest.mark.parametrize("seed", range(8))
def test_standing_obstacles_are_never_touched(seed):
    """Whatever the tools are asked to do: the margin holds to what a tick's curvature takes."""
    rng = np.random.default_rng(seed)
    q = home()
    obstacles = {}
    while len(obstacles) < 6:
        config = ObstacleConfig(
            tuple(rng.uniform([-1.0, -1.5, 0.1], [3.0, 1.5, 1.3])), rng.uniform(0.05, 0.25)
        )
        if min(rooms(team_with(one=config), q, 0.0, robot).min() for robot in (0, 1)) > 0.0:
            obstacles[f"o{len(obstacles)}"] = config
    told = closed_loop(team_with(**obstacles), q, far_goals(rng, q), 3.0)
    assert told[:, 0].min() >= 0.05 - 2e-3
    assert told[:, 0].min() <= 0.2, "somebody came near"


@pytest.mark.parametrize("seed", range(8))
def test_a_moving_obstacle_is_evaded(seed):
    """It comes straight at a robot at up to 0.5 m/s, high or low."""
    rng = np.random.default_rng(seed)
    q, robot = home(), int(rng.integers(2))
    spheres = team().spheres(q)
    aim = spheres.centers[24 * robot + int(rng.integers(24))]
    angle, speed = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.2, 0.5)
    velocity = speed * np.array([np.cos(angle), np.sin(angle), 0.0])
    start = aim - velocity * (1.6 / speed)
    ball = ObstacleConfig(tuple(start), 0.1, velocity=tuple(velocity))
    told = closed_loop(
        team_with(ball=ball),
        q,
        References(team().tools(q), (np.zeros(3), np.zeros(3))),
        3.2 / speed,
    )
    assert told[:, 0].min() >= 0.05 - 2e-3
    assert told[:, 1].max() <= 1e-3


def test_robots_that_are_sent_into_each_other_stop_in_front():
    q = home()
    tools = team().tools(q)
    goals = References(
        tuple(Pose(np.array([1.0, 0.0, 0.8]), tool.rotation) for tool in tools),
        (np.zeros(3), np.zeros(3)),
    )
    told = closed_loop(team(), q, goals, 4.0, robots=["robot_b"])
    assert told[:, 0].min() >= 0.05 - 2e-3
    assert told[-1, 0] <= 0.06, "they have met"
