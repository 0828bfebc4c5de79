"""The end of a motion that has been cut, on an axis that needs time to stop.

    Immediate Stop, emergency stop, limit, program mode
    |
    |<-- CutShort: the motion bits stay -->| STOPPED
    axis.cut()                             the axis is known to be at rest

A 3601 stops its steps at once, so it never needs this operation. A controller on a line keeps making steps
until it has received the stop, and only a later reply shows that it is at rest.
"""

from __future__ import annotations

from typing import ClassVar

from typing_extensions import override

from ..operation import Host, Limits, Operation


class CutShort(Operation):
    """A motion that has been cut; it lasts until the axis is known to be at rest.

    Args:
        cut: the motion; its name and start are kept.
        completion: the completion bit at the end, or 0.
        outcome: the outcome, for the trace.
    """

    limits: ClassVar[Limits] = Limits.OWN  # a limit can't cut it again

    def __init__(self, host: Host, now_ns: int, cut: Operation, completion: int, outcome: str) -> None:
        super().__init__(host, cut.started_ns)
        self.cut_ns = now_ns
        self.name = cut.name  # type: ignore[misc]  # the name of any operation
        self.status_lsw = cut.status_lsw  # type: ignore[misc]  # as above
        self.started_at = cut.started_at
        self.completion = completion
        self.outcome = outcome

    @override
    def on_end(self, now_ns: int) -> None:
        self.host.finish(now_ns, self.completion, self.outcome)
