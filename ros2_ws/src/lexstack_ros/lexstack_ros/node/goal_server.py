"""An action server whose goals cost nothing while they are under way."""

from __future__ import annotations

from typing import Any

from rclpy.action.server import ActionServer, ServerGoalHandle


class GoalServer(ActionServer):
    """An action server whose goals end when they are said to, at no cost until then.

    rclpy's own way is a coroutine for each goal. One that waits is asked again and again whether
    it goes on: that keeps a core busy for as long as a goal is under way.
    """

    def notify_execute(self, _handle: ServerGoalHandle, _callback: Any) -> None:
        """Let a goal begin: it is executing now, and nothing waits for its end."""

    def finish(self, handle: ServerGoalHandle) -> None:
        """Call the server's callback for a goal's result, and send it."""
        super().notify_execute(handle, None)
