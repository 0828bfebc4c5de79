"""MC_TouchProbe: the position at the capture input's edge."""

from __future__ import annotations

from collections.abc import Callable

from scanrack.io_images.amci3601.bits import StatusLsw
from scanrack.io_images.amci3601.status import StatusView
from typing_extensions import override

from .errors import AxisError, ErrorId, reasons
from .kinds import State
from .link import Link, LinkedWait

_CAPTURE = StatusLsw.IN_CAPTURE.value


class CaptureWait(LinkedWait[int]):
    """A wait for a rising capture input; a pulse shorter than a scan shows only in the captured value."""

    __slots__ = ("_axis", "_last", "_state", "_status", "_was_on", "_words")

    def __init__(
        self, axis: str, words: memoryview, status: StatusView, state: Callable[[], State], link: Link
    ) -> None:
        super().__init__()
        self.follow(link)
        self._axis, self._words, self._status, self._state = axis, words, status, state
        self._was_on = True
        self._last = 0

    @override
    def begin(self, now_ns: int) -> None:
        self._was_on = self._words[1] & _CAPTURE != 0
        self._last = self._status.captured

    @override
    def poll(self, now_ns: int) -> bool:
        """Return whether the input rose, or a value was captured, since the previous scan."""
        if self._state() is State.DISABLED:
            text = f"{self!r}: {reasons(ErrorId.WRONG_STATE, 'state DISABLED')}"
            raise AxisError(text, ErrorId.WRONG_STATE)
        was_on, self._was_on = self._was_on, self._words[1] & _CAPTURE != 0
        has_risen = self._was_on and not was_on
        value, self._last = self._last, self._status.captured
        return has_risen or value != self._last

    @override
    def result(self) -> int:
        """Return the captured value: steps, or encoder counts if an encoder is configured."""
        return self._last

    @property
    @override
    def call(self) -> str:
        return f"{self._axis}.captured()"
