"""How to bring a PCL601 that ignores Modbus back from AA ASCII [Anaheim Automation ASCII, Direct Talk].

8E1  | request, no reply |                              | request, reply
8N1                      | @% CR  | 1 CR LF |  @1| CR  |

`@%` asks every device in AA ASCII for its address; `|` has no reply.
"""

from __future__ import annotations

from functools import partial

from .master import LineRequest, Reply, Verdict
from .wire import LineFormat

LINE_FORMAT = LineFormat(38_400, "N")
ASK = b"@%\r"
ANSWER_MAX = 4
"""Longest answer: two digits, CR and LF."""


def ask_address(unit: int) -> LineRequest:
    """Return the request for the address; it accepts only a reply from `unit`."""
    return LineRequest(ASK, ANSWER_MAX, partial(_read, unit=unit), LINE_FORMAT)


def back_to_modbus(unit: int) -> LineRequest:
    r"""Return the command that ends AA ASCII; it has no reply.

    >>> back_to_modbus(1).frame
    b'@1|\r'
    """
    return LineRequest(b"@%d|\r" % unit, 0, lambda heard: Verdict.FOREIGN, LINE_FORMAT)


def _read(heard: bytes, unit: int) -> Reply | Verdict:
    r"""Read an address.

    >>> _read(b"7", unit=7), _read(b"12\r\n", unit=7)
    (<Verdict.UNFINISHED: 'unfinished'>, <Verdict.FOREIGN: 'no reply to this request'>)
    """
    digits = heard.removesuffix(b"\r\n")
    if digits == heard:
        return Verdict.UNFINISHED
    return Reply(heard) if digits.isdigit() and int(digits) == unit else Verdict.FOREIGN
