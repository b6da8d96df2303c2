"""Transitions: how the command goes from one stack's optimum to a source's, within limits."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.transition.bridge import Bridge
    from lexstack.transition.gap_motion import GapMotion
    from lexstack.transition.manager import Transition
    from lexstack.transition.messages import (
        Announcement,
        Phase,
        Source,
        SourceSample,
        SourceSchedule,
        TransitionState,
    )
    from lexstack.transition.methods import (
        JERK_LIMITED,
        METHODS,
        Levels,
        Method,
        View,
        register_method,
    )
    from lexstack.transition.options import TransitionConfig, TransitionOptions
    from lexstack.transition.profiles import PROFILES, alpha, quintic
    from lexstack.transition.requests import (
        MAX_DURATION,
        MAX_SCHEDULED,
        Answer,
        SwitchRequest,
        too_far,
    )
    from lexstack.transition.robot_group import Columns
    from lexstack.transition.sources.inbox import LocalSource
    from lexstack.transition.sources.mpc_plans import HeardPlan
else:
    __getattr__ = on_demand(
        __name__,
        {
            "bridge": "Bridge",
            "gap_motion": "GapMotion",
            "manager": "Transition",
            "messages": "Announcement Phase Source SourceSample SourceSchedule TransitionState",
            "methods": "JERK_LIMITED METHODS Levels Method View register_method",
            "options": "TransitionConfig TransitionOptions",
            "profiles": "PROFILES alpha quintic",
            "requests": "MAX_DURATION MAX_SCHEDULED Answer SwitchRequest too_far",
            "robot_group": "Columns",
            "sources.inbox": "LocalSource",
            "sources.mpc_plans": "HeardPlan",
        },
    )

__all__ = [
    "JERK_LIMITED",
    "MAX_DURATION",
    "MAX_SCHEDULED",
    "METHODS",
    "PROFILES",
    "Announcement",
    "Answer",
    "Bridge",
    "Columns",
    "GapMotion",
    "HeardPlan",
    "Levels",
    "LocalSource",
    "Method",
    "Phase",
    "Source",
    "SourceSample",
    "SourceSchedule",
    "SwitchRequest",
    "Transition",
    "TransitionConfig",
    "TransitionOptions",
    "TransitionState",
    "View",
    "alpha",
    "quintic",
    "register_method",
    "too_far",
]
