"""A question about a run, and the scan to which it refers."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import parse_time
from scanrack.traces.replay import PackedTrace


class NotReachedError(AssertionError):
    """A condition did not become true in time; the message shows the bench.

    Attributes:
        tags: the tags that the condition read.
    """

    def __init__(self, text: str, tags: Iterable[str] = ()) -> None:
        super().__init__(text)
        self.tags = tuple(tags)


@dataclass(frozen=True, slots=True)
class ScanChoice:
    """The scan to which a question refers, set by one of three fields; by default, the last scan.

    Raises:
        ValueError: more than one field is set, or `at` is neither a time nor a number.
    """

    at: str | None = None  # a time with a unit, such as "1.5 s", or the number of a scan
    scans: int | None = None  # number of scans from power-up
    until: str | None = None  # a tag or an address of a bit; the first scan in which it is true

    def __post_init__(self) -> None:
        options = (("--at", self.at), ("--scans", self.scans), ("--until", self.until))
        names = [name for name, value in options if value is not None]
        if len(names) > 1:
            raise ValueError(f"{' and '.join(names)} exclude each other: use one of them")
        if self.at is not None and self.number is None:
            parse_time(self.at)

    @property
    def number(self) -> int | None:
        """The number of the scan, if `at` is a number."""
        return int(self.at) if self.at is not None and self.at.strip().isdecimal() else None

    def scans_from_power_up(self, period_ns: int) -> int | None:
        """Return the number of scans from power-up to the chosen scan; None if it depends on the run."""
        if self.scans is not None:
            return self.scans
        if self.number is not None:
            return self.number + 1
        # + 1 because the scan at exactly that time is included
        return None if self.at is None else parse_time(self.at) // period_ns + 1

    def row(self, recording: PackedTrace) -> int:
        """Return the chosen row of a recording; `until` is ignored.

        Raises:
            ValueError: the recording has no such scan.
        """
        rows = len(recording.scans)
        row = rows - 1 if self.scans is None else self.scans - 1
        if self.number is not None:
            row = bisect_right(recording.numbers, self.number) - 1
            if row < 0 or recording.numbers[row] != self.number:
                raise _missing_scan(recording, f"scan {self.number:,}")
        elif self.at is not None:
            row = bisect_right(recording.times, parse_time(self.at)) - 1
        if not 0 <= row < rows:
            choice = f"{self.scans} scans" if self.at is None else f"a scan by {self.at}"
            raise _missing_scan(recording, choice)
        return row


@dataclass(frozen=True, slots=True)
class Question:
    """A question about a run, after one of its scans."""

    what: str | None  # see `Bench.why`
    moment: ScanChoice
    deep: bool = False  # whether the chain also includes rungs of add-on instructions
    want: str | None = None  # a value for `what`; the answer then also explains how it could get this value


def _missing_scan(recording: PackedTrace, choice: str) -> ValueError:
    first, last = recording.numbers[0], recording.numbers[-1]
    return ValueError(f"the trace does not have {choice}: it has scans {first:,} to {last:,}")
