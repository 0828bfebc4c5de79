"""Finds the instants that explain what was read. Each choice of instants is a hypothesis: a run of the model.

    write   acts at an instant in its window, or within the lag after it: one hypothesis per `GRID_NS`
    read    shows what the model shows at an instant in its window, or within the lag before it. Each pair of
            words may be from another instant, but a controller tears no pair.

Words that act while the axis moves make its position uncertain by the steps between two tried instants,
until it is read at rest.

A hypothesis that does not explain a read is dropped. Hypotheses in the same state are merged. A read that no
hypothesis explains is a difference. The search gives up if there are more than `most` hypotheses at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from typing import Any, NamedTuple

from scanrack.runtime.modules.amci3601.module import Amci3601

from .branch import GRID_NS, MODE_CONFIG, SAMPLE_NS, Branch
from .moments import ImageWords, KnownState, Moment, SeenImage, Timing, Transmission, Window

MOST = 4000
"""Number of hypotheses at a time above which a scene is given up."""

MERGE_READS = 10
"""Number of reads after which branches are compared."""

NEVER = 1 << 62

ModelFactory = Callable[[], Amci3601]

_BROKEN = (ArithmeticError, AssertionError, ValueError)
"""Errors that a model raises when it reaches an impossible state."""


@dataclass(slots=True)
class Search:
    """The result of a search over instants.

    Attributes:
        left: hypotheses that explain all reads.
        reads: number of reads that were judged.
        most: largest number of hypotheses at a time.
        runs: number of hypotheses that were tried.
        unexplained: the first read that no hypothesis explains, or None.
        shown: images around that read, of a hypothesis that explained all earlier ones.
        after: what was sent last before the search ended.
        many: how many hypotheses there would have been if the search gave up; else 0.
        overlapping: whether no choice of instants keeps the order in which the words were sent.
        moving: number of transmissions since the axis was last at rest.
        instants: the instants of that hypothesis, or of one that explains all reads.
        fired_anywhere: rules that fired in any hypothesis that got that far, or that explains all reads.
    """

    left: list[Branch] = field(default_factory=list)
    reads: int = 0
    most: int = 1
    runs: int = 0
    unexplained: SeenImage | None = None
    shown: list[ImageWords] = field(default_factory=list)
    after: Transmission | None = None
    many: int = 0
    overlapping: bool = False
    moving: int = 0
    instants: tuple[int, ...] = ()
    fired_anywhere: set[str] = field(default_factory=set)

    @property
    def explains_all(self) -> bool:
        """Whether any hypothesis explains every read."""
        return self.unexplained is None and not self.many and not self.overlapping

    @property
    def fired(self) -> set[str]:
        """Rules that fire in all remaining hypotheses."""
        return set.intersection(*(hypothesis.fired for hypothesis in self.left)) if self.left else set()


def search(
    moments: Sequence[Moment],
    model: ModelFactory,
    timing: Timing,
    most: int = MOST,
    given: Sequence[int] | None = None,
) -> Search:
    """Search for the instants that explain a scene.

    The module's state before its first configuration is unknown, so only later reads count. No configuration
    resets the captured value and the encoder count, so they are taken from the first read after it. In a
    scene that begins with a known state, all reads count.

    Args:
        model: makes a model that was just powered up.
        most: number of hypotheses at a time above which the search gives up.
        given: instants at which the transmissions act; None to search for them.
    """
    result = Search()
    turns = _turns(moments)
    start = _start_of(moments, turns, model, timing)
    if start is None:
        return result
    live, waiting, adopted = [start.branch], list[SeenImage](), start.is_whole
    limits = [*(turn_sent.window.low_ns for turn_sent, _ in turns[1:]), None]
    for place, ((transmission, seen), limit) in enumerate(zip(turns, limits, strict=True)):
        instants = (
            _instants(transmission, timing, single=place <= start.turn)
            if given is None
            else given[place : place + 1]
        )
        live = _spread(live, transmission, instants, _earliest(waiting, transmission, timing), result, most)
        result.after = transmission
        result.moving += 1
        if not live:
            return result
        waiting += start.judged(place, seen)
        adopted = adopted or (place > start.turn and _adopt(live, waiting))
        live, waiting = _sift(live, waiting, limit, transmission, timing, result)
        if not live:
            return result
        if all(hypothesis.rests for hypothesis in live):
            result.moving = 0
        since_ns = min((moment.window.low_ns for moment in waiting), default=limit or NEVER)
        live = _merged(live, since_ns - timing.lag_ns - 4 * GRID_NS, limit)
    result.left, result.instants = live, live[0].instants
    result.fired_anywhere = set().union(*(hypothesis.fired for hypothesis in live))
    return result


class _Start(NamedTuple):
    """The start of a search.

    Attributes:
        turn: number of the first turn with reads that are judged.
        known_ns: reads are judged from this instant on, ns.
        is_whole: whether the state is known completely, including what no configuration resets.
    """

    branch: Branch
    turn: int
    known_ns: int
    is_whole: bool

    def judged(self, place: int, seen: Sequence[SeenImage]) -> Sequence[SeenImage]:
        """Return the reads of a turn that are judged."""
        return [moment for moment in seen if place >= self.turn and moment.window.low_ns >= self.known_ns]


def _start_of(
    moments: Sequence[Moment],
    turns: Sequence[tuple[Transmission, list[SeenImage]]],
    model: ModelFactory,
    timing: Timing,
) -> _Start | None:
    """Return the start of a search: a known state, or the first configuration; None if there is neither."""
    known_state = moments[0] if moments and isinstance(moments[0], KnownState) else None
    turn = 0 if known_state else _configured_at(turns)
    if turn == len(turns):
        return None
    if known_state:
        known_ns = known_state.window.high_ns
        return _Start(Branch(model(), known_ns).resume(known_state), turn, known_ns, True)
    known_ns = turns[turn][0].window.high_ns + 2 * timing.lag_ns
    return _Start(Branch(model(), turns[0][0].window.low_ns), turn, known_ns, False)


def _configured_at(turns: Sequence[tuple[Transmission, list[SeenImage]]]) -> int:
    """Return the number of the first turn that configures; the number of turns if none does."""
    return next(
        (n for n, (transmission, _) in enumerate(turns) if transmission.words and transmission.words[0] < 0),
        len(turns),
    )


def _turns(moments: Sequence[Moment]) -> list[tuple[Transmission, list[SeenImage]]]:
    """Return each transmission with the reads before the next one."""
    turns: list[tuple[Transmission, list[SeenImage]]] = []
    for moment in moments:
        if isinstance(moment, KnownState):
            now = Window(moment.window.high_ns, moment.window.high_ns)
            turns.append((Transmission(now, moment.sent), []))
        elif isinstance(moment, Transmission):
            turns.append((moment, []))
        elif turns:
            turns[-1][1].append(moment)
    while turns and not turns[-1][1]:
        turns.pop()
    return turns


def _adopt(live: list[Branch], waiting: list[SeenImage]) -> bool:
    """Let all branches adopt the count and captured value of the first read in command mode, if any."""
    first = next((moment for moment in waiting if moment.words[0] & MODE_CONFIG == 0), None)
    if first is None:
        return False
    for branch in live:
        branch.adopt(first.words)
    return True


def _instants(sent: Transmission, timing: Timing, *, single: bool) -> Sequence[int]:
    """Return the instants at which a transmission may act; only one if the state before it is unknown."""
    high = sent.window.high_ns + timing.lag_ns
    return (high,) if single else range(sent.window.low_ns, high + 1, GRID_NS)


def _earliest(waiting: Sequence[SeenImage], sent: Transmission, timing: Timing) -> int:
    """Return the instant from which images may still be needed, ns."""
    return (
        min([sent.window.low_ns, *(moment.window.low_ns for moment in waiting)]) - timing.lag_ns - 4 * GRID_NS
    )


def _spread(
    live: list[Branch], sent: Transmission, instants: Sequence[int], keep_from: int, result: Search, most: int
) -> list[Branch]:
    """Return a branch for each instant at which a transmission may act; none if there would be too many."""
    if len(live) * len(instants) > most:
        result.many = len(live) * len(instants)
        return []
    children: list[Branch] = []
    for branch in live:
        branch.forget(keep_from)
        later = [instant for instant in instants if instant >= branch.now_ns]
        try:
            for instant in later:
                branch.advance(instant)
                children.append((branch if instant == later[-1] else branch.child(keep_from)).act(sent))
        except _BROKEN:
            continue
    result.overlapping = not children
    result.most = max(result.most, len(children))
    result.runs += len(children)
    return children


def _sift(
    live: list[Branch],
    waiting: list[SeenImage],
    limit: int | None,
    sent: Transmission,
    timing: Timing,
    result: Search,
) -> tuple[list[Branch], list[SeenImage]]:
    """Judge the reads that the next transmission can't have changed; return remaining branches and reads."""
    due = list(takewhile(lambda each: limit is None or _end(each, sent, timing) <= limit, waiting))
    for seen in due:
        kept = [hypothesis for hypothesis in live if _explains(hypothesis, seen, timing)]
        if not kept:
            result.unexplained = seen
            result.fired_anywhere = set().union(*(hypothesis.fired for hypothesis in live))
            result.instants = live[0].instants
            result.shown = live[0].shown(seen.window.low_ns - timing.lag_ns, seen.window.high_ns)
            return [], []
        live = kept
        result.reads += 1
        if len(live) > 1 and result.reads % MERGE_READS == 0:
            live = _merged(live, seen.window.low_ns - timing.lag_ns - 4 * GRID_NS, limit)
    return live, waiting[len(due) :]


def _end(seen: SeenImage, sent: Transmission, timing: Timing) -> int:
    """Return the instant up to which the model has to run to judge a read, ns."""
    drift = (seen.window.high_ns - sent.window.low_ns) * timing.drift_ppm // 1_000_000
    return seen.window.high_ns + drift + 2 * (GRID_NS + SAMPLE_NS)


def _explains(branch: Branch, seen: SeenImage, timing: Timing) -> bool:
    try:
        return branch.explains(seen, timing)
    except _BROKEN:
        return False


def _merged(live: list[Branch], since_ns: int, limit: int | None) -> list[Branch]:
    """Return one branch for each state; its fired rules are those that fired in all merged branches.

    Args:
        since_ns: images from this instant on may still be needed.
        limit: the next transmission may act from this instant on, so no branch may be later.
    """
    states: dict[Any, Branch] = {}
    now_ns = max(branch.now_ns for branch in live)
    if limit is not None and now_ns > limit:
        return live
    for branch in live:
        branch.advance(now_ns)
        equal_branch = states.setdefault(branch.state(since_ns), branch)
        equal_branch.fired &= branch.fired
        equal_branch.play = max(equal_branch.play, branch.play)
    return list(states.values())
