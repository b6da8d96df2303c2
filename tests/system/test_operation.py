"""What operators of ROS systems expect: tidy nodes, parameters, diagnostics, QoS, a clean end."""

import os
import re
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParameters
from rclpy.duration import Infinite
from rclpy.parameter import Parameter
from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible, qos_profile_sensor_data
from std_srvs.srv import SetBool

from lexstack_bringup.processes import NODES
from lexstack_ros.messages.qos import STREAM
from lexstack_testing.played_run import apart
from lexstack_testing.user import Bystander
from support.listening import sockets
from support.qos import documented_qos
from support.runs import short_scenario

pytestmark = [pytest.mark.system, pytest.mark.realtime]
ROBOTS = ("robot_a", "robot_b")
TOOLS = [f"/{r}/{t}" for r in ROBOTS for t in ("joint_states", "ee_pose", "odom")]
TARGETS = [
    f"/{r}/{t}"
    for r in ROBOTS
    for t in (
        *("ee_target", "ee_twist", "ee_trajectory", "base_target", "base_twist", "base_path"),
        "posture_trajectory",
    )
]
REFERENCES = [f"/{r}/{t}" for r in ROBOTS for t in ("ee_reference", "base_reference")]
ACTIONS = [f"/{r}/follow_joint_trajectory/_action" for r in ROBOTS]
ALWAYS = {"/rosout", "/parameter_events", "/diagnostics"}
PUBLISHES = {
    "sim_bridge": {
        *("/plant/state", "/clock", "/tf", "/tf_static", *TOOLS),
        *(f"/{r}/robot_description" for r in ROBOTS),
    },
    "hqp_controller": {
        *("/robot_a/chi", "/robot_a/transition", "/robot_a/stack_request", "/robot_a/scenario"),
        "/robot_a/references",
        *REFERENCES,
        *(f"{action}/{name}" for action in ACTIONS for name in ("feedback", "status")),
    },
    "stack_solver": {"/robot_b/chi", "/robot_b/references"},
    "recorder": set(),
}
TOPICS = {t for topics in PUBLISHES.values() for t in topics if "/_action/" not in t}
HEARS = {
    "sim_bridge": {"/robot_a/chi"},
    "hqp_controller": {
        *("/plant/state", "/robot_b/chi", "/htmpc/plan", "/robot_a/request_stack"),
        *("/diagnostics", "/robot_b/references", "/tf", "/tf_static", *TARGETS),
    },
    "stack_solver": {"/plant/state", "/robot_a/stack_request", "/robot_a/references"},
}
SERVES = {
    "sim_bridge": {f"/sim_bridge/{s}" for s in ("pause", "step", "reset", "apply_wrench")},
    "hqp_controller": {
        *("/robot_a/switch_stack", "/robot_a/cancel_transition"),
        *(f"{a}/{name}" for a in ACTIONS for name in ("send_goal", "cancel_goal", "get_result")),
    },
    "stack_solver": set(),
    "recorder": set(),
}


@pytest.fixture(scope="module")
def user(tmp_path_factory):
    """Return somebody beside a long realtime run that has begun."""
    scenario = short_scenario(mode="realtime", events=(), duration=600.0)
    with apart(scenario, tmp_path_factory.mktemp("run")) as run:
        user = Bystander(run, run.player)
        assert user.call(SetBool, "/sim_bridge/pause", data=False).success
        yield user


def names(pairs):
    return {name for name, _ in pairs}


@pytest.mark.parametrize("node", NODES)
def test_a_node_has_the_topics_and_services_that_it_shall_have_and_no_other(user, node):
    """The same that ``ros2 node info`` shows."""
    graph = user.node
    published = names(graph.get_publisher_names_and_types_by_node(node, "/"))
    assert published - ALWAYS == PUBLISHES[node]
    assert published >= ALWAYS - {"/diagnostics"}
    heard = names(graph.get_subscriber_names_and_types_by_node(node, "/"))
    if node in HEARS:
        assert heard - {"/parameter_events"} == HEARS[node]
    else:
        assert heard >= TOPICS, "the recorder hears all"
    served = names(graph.get_service_names_and_types_by_node(node, "/"))
    own = {s for s in served if not re.search(r"parameters?(_types|_atomically)?$", s)}
    assert own - {f"/{node}/get_type_description"} == SERVES[node]
    assert graph.get_node_names().count(node) == 1


@pytest.mark.parametrize("node", NODES)
def test_the_ticks_go_before_what_works_beside_them(user, node):
    pid = user.run.process(node).pid
    mine = os.getpriority(os.PRIO_PROCESS, os.getpid())
    threads = [int(task.name) for task in Path(f"/proc/{pid}/task").iterdir()]
    above = {os.getpriority(os.PRIO_PROCESS, thread) - mine for thread in threads}
    assert above == {5 if node == "recorder" else 0}


@pytest.mark.parametrize("node", NODES)
def test_every_parameter_says_what_it_is(user, node):
    listed = user.call(ListParameters, f"/{node}/list_parameters").result.names
    own = [
        n
        for n in listed
        if n not in ("use_sim_time", "start_type_description_service")
        and not n.startswith("qos_overrides")
    ]
    assert own
    described = user.call(DescribeParameters, f"/{node}/describe_parameters", names=own)
    for descriptor in described.descriptors:
        assert descriptor.description, descriptor.name
        numeric = descriptor.type in (2, 3)
        assert not numeric or descriptor.floating_point_range or descriptor.integer_range
        tunable = descriptor.name in ("transition_duration", "transition_method", "lead_in")
        assert descriptor.read_only != tunable, descriptor.name


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [
        ("transition_duration", 0.0, "range"),
        ("transition_duration", 1e9, "range"),
        ("transition_duration", float("nan"), "range"),
        ("transition_duration", float("inf"), "range"),
        ("transition_duration", "x", "type"),
        ("transition_method", "jump", "unknown method 'jump'; known: bridge"),
        ("transition_method", 1, "type"),
        ("scenario", "/other.yaml", "read-only"),
        ("no_such_parameter", 1, "not been declared|undeclared|not declared"),
    ],
)
def test_a_wrong_parameter_is_refused_with_a_reason(user, name, value, why):
    parameter = Parameter(name=name, value=value).to_parameter_msg()
    answer = user.call(SetParameters, "/hqp_controller/set_parameters", parameters=[parameter])
    assert not answer.results[0].successful
    assert re.search(why, answer.results[0].reason), answer.results[0].reason


def test_diagnostics_tell_rates_times_misses_and_ages(user):
    heard = []
    subscription = user.node.create_subscription(
        DiagnosticArray, "/diagnostics", lambda m: heard.extend(m.status), STREAM
    )
    user.until(lambda: {s.name for s in heard} == set(NODES) and len(heard) > 8)
    user.node.destroy_subscription(subscription)
    last = {s.name: {v.key: v.value for v in s.values} for s in heard}
    robot_a, bridge = last["hqp_controller"], last["sim_bridge"]
    assert 10.0 < float(robot_a["rate [Hz]"]) < 150.0, "about 100 ticks a second"
    median, longest = (float(robot_a[f"solve time, {k} [us]"]) for k in ("median", "longest"))
    assert 20.0 < median <= longest < 1e6, "a tick takes hundreds of microseconds"
    # A state comes every 10 ms, a report every second; both are behind the state by a transport.
    assert 0.0 < float(robot_a["age of the last /plant/state [ms]"]) < 1000.0
    assert 0.0 < float(robot_a["least delay of /plant/state [ms]"]) < 1000.0
    assert robot_a["ticks without the solver in time"] == "0", "nobody has asked for the solver"
    assert robot_a["refused messages"] == "0"
    assert int(bridge["late ticks"]) <= int(robot_a["tick"])
    assert int(bridge["missing ticks"]) <= int(robot_a["tick"])
    assert bridge["refused commands"].isdecimal()
    assert bridge["commander"].startswith("hqp_controller@")
    assert int(last["recorder"]["messages"]) > 100
    assert last["recorder"]["lost"] == "0"


def test_a_refused_message_is_counted_in_the_diagnostics(user):
    heard = []
    subscription = user.node.create_subscription(
        DiagnosticArray, "/diagnostics", lambda m: heard.extend(m.status), STREAM
    )

    def refused():
        values = [{v.key: v.value for v in s.values} for s in heard if s.name == "hqp_controller"]
        return int(values[-1]["refused messages"]) if values else None

    user.until(lambda: refused() is not None)
    before = refused()
    publisher = user.publisher(PoseStamped, TARGETS[0], listeners=2)
    wrong = PoseStamped()
    wrong.header.frame_id = "world"
    wrong.pose.position.x = float("nan")
    publisher.publish(wrong)
    user.until(lambda: refused() == before + 1)
    user.node.destroy_publisher(publisher)
    user.node.destroy_subscription(subscription)


def test_every_topic_is_heard_with_the_defaults_of_the_tools_and_hears_them(user):
    """``ros2 topic echo`` and rosbag2 ask for a topic with their defaults; ``pub`` offers them."""
    defaults = {"reliable": QoSProfile(depth=10), "best effort": qos_profile_sensor_data}
    graph = user.node
    for topic in set().union(*PUBLISHES.values()):
        offered = [e.qos_profile for e in graph.get_publishers_info_by_topic(topic)]
        assert offered, topic
        for profile in offered:
            for name, default in defaults.items():
                fits, why = qos_check_compatible(profile, default)
                assert fits != QoSCompatibility.ERROR, (topic, name, why)
    for topic in ("/robot_a/request_stack", *TARGETS):
        for end in graph.get_subscriptions_info_by_topic(topic):
            if end.node_name in HEARS:
                # What ``ros2 topic pub`` offers; the graph names what is infinite by its value.
                offered = QoSProfile(
                    depth=10, deadline=Infinite, liveliness_lease_duration=Infinite
                )
                fits, why = qos_check_compatible(offered, end.qos_profile)
                assert fits != QoSCompatibility.ERROR, (topic, why)


def test_the_documented_qos_is_the_one_that_is_offered(user):
    """But for the depth, which no process tells another: that is held against the sources."""
    documented = {
        topic.replace("NAME", robot): qos[:2]
        for topic, qos in documented_qos().items()
        for robot in (ROBOTS if "NAME" in topic else ("",))
    }
    for topic in TOPICS | {"/diagnostics"}:
        offers = user.node.get_publishers_info_by_topic(topic)
        ours = [e.qos_profile for e in offers if e.node_name in NODES]
        for profile in ours:
            offered = (
                profile.reliability.name.lower(),
                profile.durability.name.lower().replace("_", " "),
            )
            assert documented[topic] == offered, topic


def test_only_udp_ports_of_dds_are_open(user):
    """DDS: 7400 + 250 domain, and from there 0, 1 (multicast), 10 + 2 p, 11 + 2 p (process p)."""
    domain = int(os.environ["ROS_DOMAIN_ID"])
    first = 7400 + 250 * domain
    for child in user.run.supervisor.children:
        tcp, udp = sockets(child.process.pid)
        assert not tcp, (child.name, tcp)
        listening = [(host, port) for host, port in udp if first <= port < first + 250]
        assert listening, child.name
        others = [(host, port) for host, port in udp if not first <= port < first + 250]
        # Beside them: what Fast DDS sends from, and the multicast port of the shared memory.
        assert len(others) <= 4, (child.name, others)
