"""Stubs: what stands for the other end of an instruction that leaves the controller.

STUB MSG : done after 20 ms                     // every message
STUB Order : error 16#00CB after 1000 ms        // the message of this tag
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal

from .errors import LadderError

ALL_MESSAGES = "MSG"
"""Name of the stub of every message without one of its own."""

_TEXT = re.compile(
    r"(?:done|error\s+(?:16#(?P<hex>[0-9A-F]{1,4})|(?P<code>\d{1,5})))\s+after\s+(?P<ms>\d{1,9}(?:\.\d{1,6})?)\s*ms",
    re.IGNORECASE,
)


@dataclass(frozen=True, slots=True)
class Stub:
    """How a message ends.

    Attributes:
        after_ns: how long it takes, ns.
        error: 0 if it succeeds, else what its ERR becomes, 1 to 65,535.
    """

    after_ns: int
    error: int = 0

    def __str__(self) -> str:
        what = f"error 16#{self.error:04X}" if self.error else "done"
        return f"{what} after {(Decimal(self.after_ns) / 1_000_000).normalize():f} ms"


def parse_stub(text: str) -> Stub:
    """Read how a message ends.

    >>> str(parse_stub("done after 20 ms")), parse_stub("error 203 after 0.5 ms")
    ('done after 20 ms', Stub(after_ns=500000, error=203))

    Raises:
        LadderError: it is something else.
    """
    found = _TEXT.fullmatch(text.strip())
    error = int(found["hex"], 16) if found and found["hex"] else int(found["code"] or 0) if found else 0
    if found is None or error > 0xFFFF or ("error" in text.lower() and not error):
        raise LadderError(
            f"{text!r} is not a stub; write 'done after 20 ms', or 'error 16#00CB after 20 ms' "
            "with a code up to 16#FFFF"
        )
    return Stub(int(Decimal(found["ms"]) * 1_000_000), error)


def stub_of(stubs: Mapping[str, Stub], path: str) -> Stub | None:
    """Return the stub of a message, None without one.

    Args:
        stubs: by name in capitals.
        path: the message's tag.
    """
    return stubs.get(path.upper()) or stubs.get(ALL_MESSAGES)
