"""Which topics a recording takes, by the rules and words of ``ros2 bag record``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from lexstack_bag.errors import BagError


@dataclass(frozen=True, slots=True)
class Selection:
    """What to take and what to leave out; by default every topic that is not hidden.

    Attributes:
        topics: take these; with ``regex``, also those that it fits.
        regex: take topics whose name contains it; empty: no such rule.
        exclude_topics: leave these out.
        exclude_regex: leave out topics whose name contains it; empty: none.
        exclude_topic_types: leave out topics of these types (pkg/msg/Type).
    """

    topics: tuple[str, ...] = ()
    regex: str = ""
    exclude_topics: tuple[str, ...] = ()
    exclude_regex: str = ""
    exclude_topic_types: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Raise BagError for an expression that is none, or a topic without its slash."""
        for key in ("regex", "exclude_regex"):
            try:
                re.compile(getattr(self, key))
            except re.error as error:
                raise BagError(f"{key}: {getattr(self, key)!r}: {error}") from error
        for key in ("topics", "exclude_topics"):
            for topic in getattr(self, key):
                if not topic.startswith("/"):
                    raise BagError(f"{key}: a topic begins with /, got {topic!r}")

    def takes(self, topic: str, type_name: str) -> bool:
        """Return whether a topic is to be recorded."""
        if topic in self.exclude_topics or type_name in self.exclude_topic_types:
            return False
        if self.exclude_regex and re.search(self.exclude_regex, topic):
            return False
        if not self.topics and not self.regex:
            return True
        return topic in self.topics or bool(self.regex and re.search(self.regex, topic))
