"""Options that several commands have, and the parser of --range."""

from __future__ import annotations

import re
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from scanrack.io_images.text_limits import EXPORT_MIB, EXPORT_MIB_MOST

if TYPE_CHECKING:  # options import no recordings
    from scanrack.traces.signals import Selection

ScanRange = tuple[int, int | None]
"""First and last scan, inclusive; None = to the end."""


class UaSecurityWord(StrEnum):
    """Values of --opc-ua-security, see `kinds.OPEN` and `kinds.ENCRYPTED`."""

    NONE = "none"
    ENCRYPTED = "encrypted"


TraceArgument = Annotated[
    Path, typer.Argument(metavar="TRACE", help="Trace, an MCAP file.", show_default=False)
]
TrustOption = Annotated[bool, typer.Option("--trust", help="Run Python that came with the trace.")]
ScansOption = Annotated[
    int | None, typer.Option("--scans", metavar="N", help="Number of scans to run, instead.")
]
RangeOption = Annotated[
    list[str] | None,
    typer.Option(
        "--range",
        metavar="A:B",
        help="Only these scans, such as 100:200, or this time, such as 1.5s:3s or 10min: .",
        show_default="all",
    ),
]
ReplaceOption = Annotated[
    bool, typer.Option("--replace", help="Overwrite; keep no numbered copies such as rack.1.mcap.")
]
KeepValuesOption = Annotated[
    bool,
    typer.Option("--keep-values", help="Keep the values of an export; no prescan resets them."),
]
MemoryOption = Annotated[
    int | None,
    typer.Option(
        "--memory",
        metavar="MIB",
        min=1,
        max=EXPORT_MIB_MOST,
        help=f"Maximum memory for the tags of an export [default: {EXPORT_MIB} MiB].",
        show_default=False,
    ),
]
ForcesOption = Annotated[bool, typer.Option("--forces", help="Apply forces from the export.")]
ServerOption = Annotated[
    list[str] | None,
    typer.Option(
        "--server",
        metavar="PROTOCOL[:[HOST:]PORT]",
        help="Serve the tags to HMIs and scripts on this machine: ethernet-ip (like a CompactLogix), opc-ua, "
        "modbus-tcp.",
        show_default=False,
    ),
]
UaSecurityOption = Annotated[
    UaSecurityWord | None,
    typer.Option(
        "--opc-ua-security",
        metavar="none|encrypted",
        help="Security of the OPC UA server: encrypted = Basic256Sha256, certificate in opcua/.",
        show_default="none on this machine, else encrypted",
    ),
]
UaUsersOption = Annotated[
    Path | None,
    typer.Option(
        "--opc-ua-users",
        metavar="FILE",
        help="Require a login; FILE has lines name:password, and only you may read it.",
    ),
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar and no summary.")]


def selection(ranges: Sequence[str] | None) -> Selection:
    """Return the selection of --range: a range of scans, of time, or both.

    >>> selection(["10:20", "1.5s:"])
    Selection(first=10, last=20, start_ns=1500000000, end_ns=None)

    Raises:
        ValueError: a text is not a range, or two ranges are of the same kind.
    """
    from scanrack.traces.signals import Selection

    scans = [text for text in ranges or () if re.fullmatch(r"[\d:\s]*", text)]
    times = [text for text in ranges or () if text not in scans]
    if len(scans) > 1 or len(times) > 1:
        raise ValueError(f"--range {' and '.join(scans if len(scans) > 1 else times)}: give only one")
    first, last = parse_range(scans[0]) if scans else (0, None)
    start_ns, end_ns = parse_time_range(times[0]) if times else (0, None)
    return Selection(first, last, start_ns, end_ns)


def parse_range(text: str) -> ScanRange:
    """Read a range of scans: `A:B`, `A:`, `:B` or `A`, both ends included.

    >>> parse_range("100:200"), parse_range("100:"), parse_range(":200"), parse_range("7")
    ((100, 200), (100, None), (0, 200), (7, 7))

    Raises:
        ValueError: the text is not a range of scans.
    """
    match = re.fullmatch(r"(\d*)(:?)(\d*)", text)
    if match is None or not (match[1] or match[3]):
        raise ValueError(f"--range {text!r}: must be A:B, A:, :B or A")
    first = int(match[1] or 0)
    last = int(match[3]) if match[3] else None
    if not match[2]:  # one scan
        last = first
    if last is not None and last < first:
        raise ValueError(f"--range {text!r}: ends before it begins")
    return first, last


def parse_time_range(text: str) -> tuple[int, int | None]:
    """Return a range of virtual time in ns, both ends included; raise ValueError for any other text.

    >>> parse_time_range("1.5s:3s"), parse_time_range(":250 ms"), parse_time_range("2min:")
    ((1500000000, 3000000000), (0, 250000000), (120000000000, None))
    """
    from scanrack.io_images.times import parse_time

    start, colon, end = map(str.strip, text.partition(":"))
    if not colon or not (start or end):
        raise ValueError(f"--range {text!r}: must be A:B, A: or :B, as in 1.5s:3s")
    start_ns = parse_time(start) if start else 0
    end_ns = parse_time(end) if end else None
    if end_ns is not None and end_ns < start_ns:
        raise ValueError(f"--range {text!r}: ends before it begins")
    return start_ns, end_ns
