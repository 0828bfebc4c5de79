"""Units of time in rack files, queries and sequences."""

from __future__ import annotations

from collections.abc import Mapping

UNITS_NS: Mapping[str, int] = {
    "ns": 1,
    "us": 1_000,
    "µs": 1_000,
    "ms": 1_000_000,
    "s": 1_000_000_000,
    "min": 60_000_000_000,
    "h": 3_600_000_000_000,
}
"""Length of each unit, ns."""

DEFAULT_RUN = "10 s"
"""Default machine time of a run in virtual time."""
