"""Runs one node in one process: one executor, and a clean end whatever the signals."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FrameType

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from lexstack.errors import ConfigurationError, LexstackError
from lexstack_config.scenario import Mode
from lexstack_ros.node.parent import end_with_supervisor

BAD_ARGUMENT = 2
LAST = 10
"""Niceness of what may wait the longest."""
_BESIDE = 5

_WAIT = 0.2  # s, after which the loop looks whether it is to end


def run_node(factory: Callable[[], Node]) -> int:
    """Run the node that ``factory`` makes until SIGINT, SIGTERM or a shutdown of ROS.

    A node with a ``niceness`` above 0 leaves the processors to others that need them: where there
    are fewer cores than processes, what must be in time at every tick goes first.

    A node that can not go on sets its attribute ``failure`` to a LexstackError: an executor does
    not hand on what a callback raises. A node with a method ``close`` has it called before it is
    destroyed, while it can still publish and log. Signals only set a flag: no callback is torn
    apart by KeyboardInterrupt, and a second signal does not disturb the end.

    Returns:
        The exit code: 0, or 2 when the node raised a LexstackError, whose line is printed.
    """
    stop = _StopFlag()
    end_with_supervisor()
    try:
        begin_ros(sys.argv)
    except ConfigurationError as error:
        print(f"error: {error}", file=sys.stderr, flush=True)
        return BAD_ARGUMENT
    executor = EventsExecutor()
    node: Node | None = None
    try:
        node = factory()
        _yield_to_others(getattr(node, "niceness", 0))
        executor.add_node(node)
        # A full collection looks at 75 000 objects of the libraries, for 20 ms: two ticks. None of
        # them ever goes, so from now on it looks at what is made while the node runs.
        gc.collect()
        gc.freeze()
        # Never executor.spin(): in this version it fires nothing and ignores signals.
        while rclpy.ok() and not stop:
            executor.spin_once(timeout_sec=_WAIT)
            failure = getattr(node, "failure", None)
            if failure is not None:
                raise failure
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except LexstackError as error:
        print(f"error: {error}", file=sys.stderr, flush=True)
        return BAD_ARGUMENT
    finally:
        stop.ignore_more()
        executor.shutdown()
        if node is not None:
            getattr(node, "close", lambda: None)()
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


def begin_ros(arguments: list[str]) -> None:
    """Begin with a node's command line; raises ConfigurationError where it is wrong.

    ROS' own signal handlers stay off, so that ROS is up until the node has closed.
    """
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except (RuntimeError, ValueError) as error:  # rclpy's own errors are RuntimeErrors
        line = " ".join(str(error).split())
        raise ConfigurationError(f"arguments of the node: {line}") from error
    unknown = remove_ros_args(arguments)[1:]
    if unknown:
        rclpy.shutdown()
        raise ConfigurationError(
            f"arguments of the node: unknown {unknown[0]!r}; parameters: --ros-args -p NAME:=VALUE"
        )


def beside(mode: Mode) -> int:
    """Return the niceness of what works beside the ticks.

    In lockstep nothing is ever late, and what does not wait for others would run away from them.
    """
    return _BESIDE if mode == "realtime" else 0


def _yield_to_others(niceness: int) -> None:
    """Raise the niceness of this process; Linux has one for each of its threads."""
    if not niceness:
        return
    tasks = Path("/proc/self/task")
    threads = [int(task.name) for task in tasks.iterdir()] if tasks.exists() else [0]
    for thread in threads:
        with suppress(ProcessLookupError):  # a thread that has ended since
            before = os.getpriority(os.PRIO_PROCESS, thread)
            os.setpriority(os.PRIO_PROCESS, thread, before + niceness)


class _StopFlag:
    """True once SIGINT or SIGTERM has come."""

    def __init__(self) -> None:
        """Listen to both signals from now on."""
        self._set = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)

    def __bool__(self) -> bool:
        """Return whether a signal has come."""
        return self._set

    def ignore_more(self) -> None:
        """Ignore both signals up to the process's last moment.

        Python gives handlers of its own back before it ends; ignored signals stay ignored.
        """
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        """Remember it."""
        self._set = True
