"""Finds the scan at which a failure becomes inevitable.

A future repeats the failing run up to a scan and has random events after it. Many futures are run for each of
several scans. The search narrows the steepest rise in failing futures down to two scans.

    scan               -1    2    4    5    6   12
    failures of 40      0    0    0   37   38   40        inevitable from scan 5

The random events change only inputs. A power cycle would end most failures and hide the rise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from random import Random
from typing import Any

from scanrack.io_images.times import seconds

from ..aim.corpus import cut
from ..aim.draws import Draws
from ..run import BrokenInvariant, TrialBench
from ..scenarios.kinds import Kind
from ..scenarios.parts import Lasting, parts_of, scenario_of, with_part
from ..scenarios.scenario import Scenario
from ..search import Counterexample, all_but
from .changes import changes_in

FUTURES = 40
"""Number of futures for each of the two scans around the rise."""

PILOT = 10
"""Number of futures for each scan during the search."""

CLEAR = 30
"""Minimum rise in failing futures within one scan that counts as clear."""

MOST_SAMPLED = 24
"""Maximum number of scans with futures."""

FAR, MOST_EVENTS = 300, 4
"""Number of scans within which a future's events begin (mostly early), and maximum number of events."""

LEAST_JUDGED = 20
"""Minimum number of scans that a future runs past the scan of the failure."""

ENDS = (1, 2, 10, 100, 1000)
"""Numbers of scans after which an active event can end."""


@dataclass(frozen=True, slots=True)
class PointOfNoReturn:
    """The scans between which the share of failing futures rises.

    Attributes:
        before: the last scan with few failing futures; -1 = power-up.
        scan: the first scan with many failing futures; `before` + 1 unless the search reached its limit.
        now_ns: time of `scan`, ns since power-up.
        few: number of futures of `before` that fail.
        many: number of futures of `scan` that fail.
        first: number of futures from power-up that fail; equal to `few` if the rise is clear.
        changes: sentences about the changes in `scan`.
    """

    before: int
    scan: int
    now_ns: int
    few: int
    many: int
    first: int
    changes: tuple[str, ...] = ()

    @property
    def is_from_the_start(self) -> bool:
        """Whether most futures that begin at power-up fail."""
        return self.first >= CLEAR

    @property
    def is_clear(self) -> bool:
        """Whether the number of failing futures rises by at least `CLEAR` within one scan."""
        return self.scan == self.before + 1 and self.many - self.few >= CLEAR

    @property
    def lines(self) -> list[str]:
        """The lines of a report."""
        if self.is_from_the_start:
            return [f"inevitable from power-up: {self.many} of {FUTURES} random futures fail"]
        counts = f"{self.many} of {FUTURES} random futures fail"
        if not self.is_clear:
            return [f"no clear instant: {self.first} fail from 0 s, {counts} from {seconds(self.now_ns)} s"]
        text = f"inevitable from scan {self.scan} ({seconds(self.now_ns)} s): {counts} from there"
        text += f", {self.few or 'none'} from scan {self.before}"
        return [text + (":" if self.changes else ""), *(f"  {change}" for change in self.changes)]


class _OutOfTimeError(Exception):
    """The time ran out during the search."""


def find_point_of_no_return(
    bench: TrialBench, failure: Counterexample, seed: int = 1, has_time: Callable[[], bool] = lambda: True
) -> PointOfNoReturn | None:
    """Return when a failure becomes inevitable; None if time runs out. This needs 100 to 250 runs.

    Args:
        seed: seed of the futures. The same seed draws the same futures.
        has_time: returns whether there is time left; called before every run.
    """
    try:
        return _locate(bench, failure, _Futures(bench, failure, seed, has_time))
    except _OutOfTimeError:
        return None


def _locate(bench: TrialBench, failure: Counterexample, futures: _Futures) -> PointOfNoReturn:
    """Find the steepest rise by bisection with few futures per scan, then count with more futures."""
    failures_by_scan = {-1: futures.count_failing(-1, PILOT), failure.broken.scan: PILOT}
    # if the pilot futures from power-up already fail often enough, all futures from there decide
    if failures_by_scan[-1] * FUTURES >= CLEAR * PILOT and (first := futures.count_failing(-1)) >= CLEAR:
        return PointOfNoReturn(before=-1, scan=0, now_ns=0, few=0, many=first, first=first)
    before, scan = _steepest_rise(failures_by_scan)
    while scan - before > 1 and len(failures_by_scan) < MOST_SAMPLED:
        middle = (before + scan) // 2
        failures_by_scan[middle] = futures.count_failing(middle, PILOT)
        before, scan = _steepest_rise(failures_by_scan)
    few = futures.count_failing(before)
    many = FUTURES if scan == failure.broken.scan else futures.count_failing(scan)
    first = few if many - few >= CLEAR else futures.count_failing(-1)
    changes = changes_in(bench, failure.scenario, scan)
    return PointOfNoReturn(
        before, scan, now_ns=scan * bench.spec.scan_ns, few=few, many=many, first=first, changes=changes
    )


def _steepest_rise(failures_by_scan: dict[int, int]) -> tuple[int, int]:
    """Return the neighboring scans with the greatest rise; if rises are equal, the scans farthest apart."""

    def rise_and_distance(pair: tuple[int, int]) -> tuple[int, int]:
        scan, next_scan = pair
        return failures_by_scan[next_scan] - failures_by_scan[scan], next_scan - scan

    return max(pairwise(sorted(failures_by_scan)), key=rise_and_distance)


class _Futures:
    """The futures of a failing run."""

    def __init__(
        self, bench: TrialBench, failure: Counterexample, seed: int, has_time: Callable[[], bool]
    ) -> None:
        self._bench, self._failure, self._seed, self._has_time = bench, failure, seed, has_time
        self._ignored = all_but(bench, failure.broken, ()) - {failure.broken.key}
        self._outcomes: dict[int, list[bool]] = {}  # of the futures so far, by scan
        self._further_outcomes: dict[int, Iterator[bool]] = {}  # runs more futures, by scan

    def count_failing(self, scan: int, count: int = FUTURES) -> int:
        """Return how many of the first futures of a scan break the same invariant.

        Args:
            count: number of futures. Only futures without a known outcome are run.
        """
        outcomes = self._outcomes.setdefault(scan, [])
        further_outcomes = self._further_outcomes.setdefault(scan, self._run_futures(scan))
        outcomes += islice(further_outcomes, max(0, count - len(outcomes)))
        return sum(outcomes[:count])

    def _run_futures(self, scan: int) -> Iterator[bool]:
        """Run futures of a scan; yield whether each fails. The first future has no new events."""
        broken: BrokenInvariant = self._failure.broken
        end_scan = broken.scan + max(LEAST_JUDGED, (broken.scan - scan) // 2)
        bench = replace(self._bench, scans=min(self._bench.scans, end_scan))
        random = Random(self._seed * 1_000_003 + scan)
        draws = Draws(bench.spec, bench.scans, (Kind.INPUTS,), random)
        future = beginning = cut(self._failure.scenario, scan, bench.spec.scan_ns)
        while True:
            if not self._has_time():
                raise _OutOfTimeError
            yield bench.run(future, without=self._ignored).broken is not None
            future = _with_future(beginning, scan, draws, random)


def _with_future(beginning: Scenario, scan: int, draws: Draws, random: Random) -> Scenario:
    """Return a beginning with a random future: active events end at random times, and new events begin."""
    future = scenario_of(
        (name, _with_random_end(part, scan, draws, random)) for name, part in parts_of(beginning)
    )
    for _ in range(random.randint(0, MOST_EVENTS)):
        event_scan = scan + int(FAR ** random.random())
        if event_scan < draws.scans and (part := draws.event(event_scan)) is not None:
            future = with_part(future, part)
    return future


def _with_random_end(part: Any, scan: int, draws: Draws, random: Random) -> Any:
    """Return a part that ends at a random time if it is active in a scan; else the same part."""
    now_ns = scan * draws.scan_ns
    if not isinstance(part, Lasting) or part.at_ns + part.for_ns <= now_ns or not part.for_ns:
        return part
    return replace(part, for_ns=now_ns + random.choice(ENDS) * draws.scan_ns - part.at_ns)
