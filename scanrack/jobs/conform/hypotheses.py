"""Finds instants that explain a scene's reads. A hypothesis is a run of the model with chosen instants.

    write   acts at an instant in its window, or within the lag after it: one hypothesis per `GRID_NS`
    read    shows the model's words at an instant in its window, or within the lag before it. Each pair of
            words may be from a different instant, but both words of a pair are from the same instant.

Words that act while the axis moves make its position uncertain by the steps between two tried instants,
until it is read at rest.

A hypothesis that fails to explain a read is dropped. Hypotheses in the same state are merged. A read that no
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
"""Maximum number of simultaneous hypotheses; beyond it, the search gives up on a scene."""

MERGE_READS = 10
"""Number of reads after which branches are compared."""

NEVER_NS = 1 << 62

ModelFactory = Callable[[], Amci3601]

_BROKEN = (ArithmeticError, AssertionError, ValueError)
"""Errors that a model raises when it reaches an impossible state."""


@dataclass(slots=True)
class Search:
    """The result of a search over instants.

    Attributes:
        explaining: hypotheses that explain all reads.
        reads: number of reads that were judged.
        most: largest number of hypotheses at a time.
        runs: number of hypotheses that were tried.
        unexplained: the first read that no hypothesis explains, or None.
        shown: images around the unexplained read, from a hypothesis that explains all earlier reads.
        last_sent: the last transmission before the search ended.
        many: number of hypotheses at which the search gave up; 0 if it did not.
        overlapping: whether no choice of instants preserves the order of the sent words.
        moving: number of transmissions since the axis was last at rest.
        instants: the instants of the hypothesis in `shown`, or of a hypothesis that explains all reads.
        fired_anywhere: rules that fired in any hypothesis that explains all reads, or all reads before the
            unexplained read.
    """

    explaining: list[Branch] = field(default_factory=list)
    reads: int = 0
    most: int = 1
    runs: int = 0
    unexplained: SeenImage | None = None
    shown: list[ImageWords] = field(default_factory=list)
    last_sent: Transmission | None = None
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
        fired = [hypothesis.fired for hypothesis in self.explaining]
        return set.intersection(*fired) if fired else set()


def search(
    moments: Sequence[Moment],
    model: ModelFactory,
    timing: Timing,
    most: int = MOST,
    fixed_instants: Sequence[int] | None = None,
) -> Search:
    """Search for the instants that explain a scene.

    The module's state before its first configuration is unknown, so only later reads count. No configuration
    resets the captured value and the encoder count: the model adopts them from the first read after it. In a
    scene that begins with a known state, all reads count.

    Args:
        model: returns a model that was just powered up.
        most: maximum number of simultaneous hypotheses; beyond it, the search gives up.
        fixed_instants: instants when the transmissions act; None to search for them.
    """
    result = Search()
    turns = _turns(moments)
    start = _start_of(moments, turns, model, timing)
    if start is None:
        return result
    live, waiting, has_adopted = [start.branch], list[SeenImage](), start.is_whole
    # a read after the beginning of the next transmission's window is judged with that transmission
    limits_ns = [*(next_sent.window.low_ns for next_sent, _ in turns[1:]), None]
    for number, ((sent, reads), limit_ns) in enumerate(zip(turns, limits_ns, strict=True)):
        if fixed_instants is None:
            # up to the first turn with reads that are judged, the exact instant does not matter
            instants = _instants(sent, timing, single=number <= start.turn)
        else:
            instants = fixed_instants[number : number + 1]
        live = _spread(live, sent, instants, _earliest(waiting, sent, timing), result, most)
        result.last_sent = sent
        result.moving += 1
        if not live:
            return result
        waiting += start.judged(number, reads)
        has_adopted = has_adopted or (number > start.turn and _adopt(live, waiting))
        live, waiting = _sift(live, waiting, limit_ns, sent, timing, result)
        if not live:
            return result
        if all(hypothesis.rests for hypothesis in live):
            result.moving = 0
        since_ns = min((read.window.low_ns for read in waiting), default=limit_ns or NEVER_NS)
        live = _merged(live, since_ns - timing.lag_ns - 4 * GRID_NS, limit_ns)
    result.explaining, result.instants = live, live[0].instants
    result.fired_anywhere = set().union(*(hypothesis.fired for hypothesis in live))
    return result


class _Turn(NamedTuple):
    """A transmission, and the reads before the next one."""

    sent: Transmission
    reads: list[SeenImage]


class _Start(NamedTuple):
    """The start of a search.

    Attributes:
        turn: number of the first turn with reads that are judged.
        known_ns: reads are judged from this instant on, ns.
        is_whole: whether the state is completely known, including values that no configuration resets.
    """

    branch: Branch
    turn: int
    known_ns: int
    is_whole: bool

    def judged(self, turn: int, reads: Sequence[SeenImage]) -> Sequence[SeenImage]:
        """Return the reads of a turn that are judged."""
        return [read for read in reads if turn >= self.turn and read.window.low_ns >= self.known_ns]


def _start_of(
    moments: Sequence[Moment],
    turns: Sequence[_Turn],
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
        return _Start(Branch(model(), known_ns).resume(known_state), turn, known_ns, is_whole=True)
    known_ns = turns[turn].sent.window.high_ns + 2 * timing.lag_ns
    return _Start(Branch(model(), turns[0].sent.window.low_ns), turn, known_ns, is_whole=False)


def _configured_at(turns: Sequence[_Turn]) -> int:
    """Return the number of the first turn that configures; the number of turns if none does."""
    for turn, (sent, _) in enumerate(turns):
        if sent.words and sent.words[0] < 0:
            return turn
    return len(turns)


def _turns(moments: Sequence[Moment]) -> list[_Turn]:
    """Return each transmission with the reads before the next one; omit final transmissions without reads."""
    turns: list[_Turn] = []
    for moment in moments:
        if isinstance(moment, KnownState):
            end = Window(moment.window.high_ns, moment.window.high_ns)
            turns.append(_Turn(Transmission(end, moment.sent), []))
        elif isinstance(moment, Transmission):
            turns.append(_Turn(moment, []))
        elif turns:
            turns[-1].reads.append(moment)
    while turns and not turns[-1].reads:
        turns.pop()
    return turns


def _adopt(live: list[Branch], waiting: list[SeenImage]) -> bool:
    """Adopt the encoder count and captured value of the first read in command mode in all branches.

    Return whether any read is in command mode.
    """
    for read in waiting:
        if read.words[0] & MODE_CONFIG == 0:
            for branch in live:
                branch.adopt(read.words)
            return True
    return False


def _instants(sent: Transmission, timing: Timing, *, single: bool) -> Sequence[int]:
    """Return the instants at which a transmission may act, ns; with `single`, only the last instant."""
    last_ns = sent.window.high_ns + timing.lag_ns
    return (last_ns,) if single else range(sent.window.low_ns, last_ns + 1, GRID_NS)


def _earliest(waiting: Sequence[SeenImage], sent: Transmission, timing: Timing) -> int:
    """Return the earliest instant of images that may still be needed, ns."""
    first_ns = min([sent.window.low_ns, *(read.window.low_ns for read in waiting)])
    return first_ns - timing.lag_ns - 4 * GRID_NS


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
                is_last = instant == later[-1]  # the branch itself can act then
                children.append((branch if is_last else branch.child(keep_from)).act(sent))
        except _BROKEN:
            continue
    result.overlapping = not children
    result.most = max(result.most, len(children))
    result.runs += len(children)
    return children


def _sift(
    live: list[Branch],
    waiting: list[SeenImage],
    limit_ns: int | None,
    sent: Transmission,
    timing: Timing,
    result: Search,
) -> tuple[list[Branch], list[SeenImage]]:
    """Judge the reads that the next transmission can't have changed.

    Return the branches that explain these reads, and the reads that must wait.
    """

    def is_due(read: SeenImage) -> bool:
        return limit_ns is None or _judged_at_ns(read, sent, timing) <= limit_ns

    due = list(takewhile(is_due, waiting))
    for read in due:
        explaining = [hypothesis for hypothesis in live if _explains(hypothesis, read, timing)]
        if not explaining:
            result.unexplained = read
            result.fired_anywhere = set().union(*(hypothesis.fired for hypothesis in live))
            result.instants = live[0].instants
            result.shown = live[0].shown(read.window.low_ns - timing.lag_ns, read.window.high_ns)
            return [], []
        live = explaining
        result.reads += 1
        if len(live) > 1 and result.reads % MERGE_READS == 0:
            live = _merged(live, read.window.low_ns - timing.lag_ns - 4 * GRID_NS, limit_ns)
    return live, waiting[len(due) :]


def _judged_at_ns(read: SeenImage, sent: Transmission, timing: Timing) -> int:
    """Return the instant that the model must reach to judge a read, ns."""
    drift_ns = (read.window.high_ns - sent.window.low_ns) * timing.drift_ppm // 1_000_000
    return read.window.high_ns + drift_ns + 2 * (GRID_NS + SAMPLE_NS)


def _explains(branch: Branch, read: SeenImage, timing: Timing) -> bool:
    try:
        return branch.explains(read, timing)
    except _BROKEN:
        return False


def _merged(live: list[Branch], since_ns: int, limit_ns: int | None) -> list[Branch]:
    """Return one branch for each state, with the rules that fired in all its merged branches.

    Args:
        since_ns: images from this instant on may still be needed.
        limit_ns: the next transmission may act from this instant on, so no branch may be later.
    """
    states: dict[Any, Branch] = {}
    now_ns = max(branch.now_ns for branch in live)
    if limit_ns is not None and now_ns > limit_ns:
        return live
    for branch in live:
        branch.advance(now_ns)
        merged = states.setdefault(branch.state(since_ns), branch)
        merged.fired &= branch.fired
        merged.play = max(merged.play, branch.play)
    return list(states.values())
