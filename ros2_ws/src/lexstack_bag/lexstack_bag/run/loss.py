"""How many messages of a topic were sent and never arrived, from their sequence numbers."""

from __future__ import annotations


class LossCounter:
    """Counts the gaps in the sequence numbers of one topic.

    Every publisher numbers its messages from 1 and they arrive in order, but a message does not
    say which publisher sent it. The counter therefore keeps the number that it expects next from
    each publisher, and takes a gap back when it turns out that two publishers share the topic.
    What was sent before the first message that arrived is not a loss.

    Attributes:
        lost: messages that did not arrive so far.
    """

    def __init__(self) -> None:
        """Start with no publisher known."""
        self.lost = 0
        self._expected: list[int] = []  # one per publisher
        self._gaps: dict[int, int] = {}  # first missing number -> number that came instead

    def see(self, number: int) -> None:
        """Take note of a message that arrived with this sequence number (from 1)."""
        if number in self._expected:
            self._expected[self._expected.index(number)] = number + 1
        elif number in self._gaps:  # not a gap, after all: another publisher came in between
            self.lost -= self._gaps.pop(number) - number
            self._expected.append(number + 1)
        else:
            earlier = [expected for expected in self._expected if expected < number]
            if earlier:
                last = max(earlier)
                self.lost += number - last
                self._gaps[last] = number
                self._expected.remove(last)
            self._expected.append(number + 1)
