"""Breakpoints of an editor, and their check after each scan, live or run again.

| kind | condition of a stop |
|---|---|
| line | the rung runs; with `becomes true` or `changes` its power does; else an expression holds |
| function | `Main.3` as a line; `Feeding changes`; any other text is an expression that becomes true |
| data | the value of a tag changes |
| exception | an error bit comes on, a rule of the manual acts, the CPU faults, a scan begins |

Expressions use the values at the end of the scan: a scan always runs to completion before a stop.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import CodeType, FrameType
from typing import Any, NamedTuple, Protocol

from scanrack.io_images.visible_text import visible
from scanrack.ladder.compiler.observed import LineKey
from scanrack.ladder.debug.watched import shown
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.python.line_marks import Observer
from scanrack.ladder.state.memory import same
from scanrack.watch.monitors.troubles import ErrorBit, error_bits

from .conditions import EngineValues, ExpressionError, NamedValues, Read, ScanContext, Values, compiled
from .protocol import DebugError, Json

BECOMES_TRUE, CHANGES = "becomes true", "changes"
"""Conditions of a line that depend on the power after its last instruction."""

FILTERS: Mapping[str, tuple[str, str]] = {
    "error": ("Error bits", "An error bit of a module comes on."),
    "rule": ("Rules of the manual", "A rule of the manual acts, such as a refused command."),
    "fault": ("Faults", "The controller faults."),
    "scan": ("Each scan", "A scan begins; with a condition such as `time > 2 s`."),
}
"""Exception breakpoints: id, label and description."""

_HITS = re.compile(r"(?P<sign>>=|>|<=|<|==|=|%)?\s*(?P<number>\d{1,9})")
_SIGNS: Mapping[str, Callable[[int, int], bool]] = {
    ">=": lambda count, number: count >= number,
    ">": lambda count, number: count > number,
    "<=": lambda count, number: count <= number,
    "<": lambda count, number: count < number,
    "==": lambda count, number: count == number,
    "=": lambda count, number: count == number,
    "%": lambda count, number: number > 0 and count % number == 0,
}
_FIELD = re.compile(r"\{([^{}]+)\}")


def tag_that_changes(text: str) -> str:
    """Return the tag of an expression such as `Level changes`; "" for any other."""
    head, _, tail = text.rpartition(" ")
    return head.strip() if tail.lower() == CHANGES else ""


@dataclass(slots=True)
class Breakpoint:
    """A breakpoint of an editor."""

    number: int
    kind: str  # line, function, data or exception
    name: str  # the function, the tag or the filter; of a line its file and number
    keys: tuple[LineKey, ...] = ()  # the rungs of a line
    condition: str = ""
    hits: str = ""  # such as `>= 5` or `% 3`; a number alone is that hit and all later ones
    log: str = ""  # of a log point: a message with expressions in braces
    line: int = 0
    path: str = ""
    count: int = 0

    @property
    def placed(self) -> bool:
        """Whether its line is a line of the running program."""
        return bool(self.keys) or not self.path

    @property
    def changing_tag(self) -> str:
        """The tag whose change it waits for; "" for any other breakpoint."""
        return self.name if self.kind == "data" else tag_that_changes(self.name)

    def counts(self) -> bool:
        """Count a hit; return whether it stops execution."""
        self.count += 1
        match = _HITS.fullmatch(self.hits.strip()) if self.hits else None
        return match is None or _SIGNS[match["sign"] or ">="](self.count, int(match["number"]))

    def check_hits(self) -> None:
        """Refuse a hit count that can't be read."""
        if self.hits and _HITS.fullmatch(self.hits.strip()) is None:
            raise DebugError(f"hit count {self.hits!r}: must be a number, or one after >=, >, <=, <, = or %")


class Hit(NamedTuple):
    """A breakpoint that was met."""

    breakpoint: Breakpoint
    text: str


Event = tuple[str, Mapping[str, Any]]
"""Topic and fields, see `traces.format.topics`."""


class ScanValues(Values, Protocol):
    """The values of a program after a scan, and the lines that ran in it."""

    in_frames: bool
    """Whether conditions and log points of lines are evaluated before the line."""

    def ran(self, key: LineKey) -> bool:
        """Whether a rung ran."""

    def true(self, key: LineKey) -> bool:
        """Whether there was power after the last instruction of a rung."""

    def at_line(self, requested: Breakpoint) -> Callable[[int], str | None] | None:
        """Return a check of whether a line ran; None for rungs, see `ran`."""


class RungValues(EngineValues):
    """`ScanValues` of a ladder program."""

    in_frames = False

    def __init__(self, engine: WatchedEngine) -> None:
        super().__init__(engine)
        self.ran = engine.ran

    def true(self, key: LineKey) -> bool:
        """See `ScanValues`."""
        engine = self.engine
        if engine.watching or engine.broken_off:
            truth = engine.truths.get(key, ())
            return bool(truth) and truth[-1]
        return engine.true_at_end(key)

    def at_line(self, requested: Breakpoint) -> None:
        """See `ScanValues`."""


class LinePoints(NamedValues, Observer):
    """Breakpoints on lines of Python and of a list of steps.

    Args:
        in_frames: conditions and log points are expressions of Python, which read the values before the line.
    """

    def __init__(self, tags: Mapping[str, Any], *, in_frames: bool) -> None:
        super().__init__(tags)
        self.in_frames = in_frames
        self.lines: set[int] = set()
        self._points: dict[LineKey, list[Callable[[FrameType | None], None]]] = {}
        self._met: dict[int, str] = {}

    def ran(self, key: LineKey) -> bool:
        """See `ScanValues`; lines are detected as they run."""
        raise NotImplementedError(key)

    true = ran

    def at_line(self, requested: Breakpoint) -> Callable[[int], str | None]:
        """See `ScanValues`."""
        condition, log = None, list[str | CodeType]()
        if self.in_frames:
            condition = _code(requested.condition) if requested.condition.strip() else None
            parts = enumerate(_FIELD.split(requested.log))
            log = [_code(part) if number % 2 else part for number, part in parts]
        number, text = requested.number, f"line {requested.line} runs"

        def look(frame: FrameType | None) -> None:
            if number not in self._met and (condition is None or _value(condition, frame, False)):
                texts = (part if isinstance(part, str) else str(_value(part, frame, "?")) for part in log)
                self._met[number] = "".join(texts) or text

        for key in requested.keys:
            self.lines.add(key[1])
            self._points.setdefault(key, []).append(look)
        return lambda _scan: self._met.pop(number, None)

    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        """Check the breakpoints of a line or step before it runs."""
        for look in self._points.get((file, line), ()):
            look(frame)


def _code(text: str) -> CodeType:
    try:
        return compile(text.strip(), "<breakpoint>", "eval")
    except (SyntaxError, ValueError) as error:
        raise ExpressionError(f"{text!r}: not an expression of Python: {error}") from error


def _value(code: CodeType, frame: FrameType | None, otherwise: object) -> Any:
    """Return the value of an expression in a frame; `otherwise` if it can't be evaluated there."""
    assert frame is not None, "a step has no expressions of Python"
    try:
        return eval(code, frame.f_globals, frame.f_locals)
    except Exception:  # the user's expression may raise anything, such as for a name that is not set yet
        return otherwise


@dataclass(slots=True)
class _Check:
    """A check of one breakpoint on an engine: returns a text if it is met, else None."""

    breakpoint: Breakpoint
    met: Callable[[int], str | None]
    allowed: Read | None
    log: list[str | Read] = field(default_factory=list)


class Looker:
    """Checks the breakpoints after each scan of an engine.

    Args:
        events: returns the events of a scan.

    Attributes:
        lines: the rungs whose power the engine must record.

    Raises:
        ExpressionError: a condition can't be evaluated.
    """

    def __init__(
        self,
        requested: Sequence[Breakpoint],
        values: ScanValues,
        around: ScanContext,
        events: Callable[[int], Sequence[Event]],
    ) -> None:
        self._values, self._around, self._events = values, around, events
        self._checks = [self._check(request) for request in requested]
        self.lines = tuple(dict.fromkeys(key for request in requested for key in request.keys))

    def prime(self, scan: int) -> None:
        """Take the current values as those of the previous scan; the power of rungs is not known yet."""
        for check in self._checks:
            if not check.breakpoint.keys:
                check.met(scan)

    def look(self, scan: int) -> list[tuple[_Check, str]]:
        """Return the breakpoints that the latest scan has met, regardless of their hit counts."""
        met = []
        for check in self._checks:
            text = check.met(scan)
            if text is not None and (check.allowed is None or check.allowed()):
                met.append((check, text))
        return met

    def hits(self, scan: int) -> list[Hit]:
        """Return the breakpoints that the latest scan has met; hit counts and log points have no effect."""
        return [Hit(check.breakpoint, text) for check, text in self.look(scan)]

    def stops(self, scan: int, say: Callable[[Breakpoint, str], object]) -> list[Hit]:
        """Return the breakpoints at which the latest scan stops; count hits, and print log points."""
        hits = []
        for check, text in self.look(scan):
            if not check.breakpoint.counts():
                continue
            if check.breakpoint.log:
                parts = (part if isinstance(part, str) else shown(part()) for part in check.log)
                say(check.breakpoint, visible("".join(parts) or text))
            else:
                hits.append(Hit(check.breakpoint, text))
        return hits

    # --- one check for each breakpoint

    def _check(self, requested: Breakpoint) -> _Check:
        power = requested.condition.strip().lower()
        on_power = requested.kind != "exception" and requested.keys and power in (BECOMES_TRUE, CHANGES)
        met = self._values.at_line(requested) if requested.keys else None
        if met is not None and self._values.in_frames:
            return _Check(requested, met, None)
        condition = None if not requested.condition or on_power else self._compiled(requested.condition)
        if met is not None:
            pass
        elif on_power:
            met = self._power(requested.keys, changes=power == CHANGES)
        elif requested.keys:
            met = self._ran(requested.keys)
        else:
            met = _MAKERS.get(requested.kind, Looker._expression)(self, requested.name)
        return _Check(requested, met, condition, self._log(requested.log))

    def _compiled(self, text: str) -> Read:
        return compiled(text, self._values, self._around)

    def _log(self, text: str) -> list[str | Read]:
        parts: list[str | Read] = []
        for number, part in enumerate(_FIELD.split(text)):
            parts.append(self._compiled(part) if number % 2 else part)
        return parts if text else []

    def _ran(self, keys: Sequence[LineKey]) -> Callable[[int], str | None]:
        ran = self._values.ran
        return lambda _scan: "the rung runs" if any(map(ran, keys)) else None

    def _power(self, keys: Sequence[LineKey], *, changes: bool) -> Callable[[int], str | None]:
        true, before = self._values.true, dict.fromkeys(keys, None)
        last_power: dict[LineKey, bool | None] = {**before}

        def met(_scan: int) -> str | None:
            text = None
            for key in keys:
                was, now = last_power[key], true(key)
                last_power[key] = now
                if was is not None and now != was and (now or changes):
                    text = f"the rung becomes {'true' if now else 'false'}"
            return text

        return met

    def _tag(self, name: str) -> Callable[[int], str | None]:
        tags = self._values.tags
        if name not in tags:
            raise ExpressionError(f"no tag {name}")
        try:
            read = self._compiled(name)
        except ExpressionError:  # an array or a structure
            read = lambda: tags[name]  # noqa: E731
        before_first: Any = object()
        last_value = before_first

        def met(_scan: int) -> str | None:
            nonlocal last_value
            before, last_value = last_value, read()
            if before is before_first or _same(before, last_value):
                return None
            return f"{name} was {shown(before)} and is {shown(last_value)}"

        return met

    def _expression(self, text: str) -> Callable[[int], str | None]:
        if tag := tag_that_changes(text):
            return self._tag(tag)
        read, last_result = self._compiled(text), True  # what holds from the beginning does not begin to hold

        def met(_scan: int) -> str | None:
            nonlocal last_result
            before, last_result = last_result, bool(read())
            return f"{text} holds" if last_result and not before else None

        return met

    def _exception(self, name: str) -> Callable[[int], str | None]:
        if name == "scan":
            return lambda scan: f"scan {scan:,} begins"
        if name == "error":
            return self._errors()
        topic, kind = ("/events", "rule") if name == "rule" else ("/faults", None)

        def met(scan: int) -> str | None:
            texts = [
                str(fields.get("text", ""))
                for event_topic, fields in self._events(scan)
                if event_topic == topic and fields.get("kind") == kind
            ]
            return "; ".join(texts) if texts else None

        return met

    def _errors(self) -> Callable[[int], str | None]:
        words: dict[tuple[int, int], list[ErrorBit]] = {}
        for _row, bit in error_bits(self._around.words):
            words.setdefault((bit.slot, bit.place.word), []).append(bit)
        last_words = dict.fromkeys(words, -1)  # before the first scan no value counts as changed

        def met(_scan: int) -> str | None:
            names = []
            for (slot, number), bits in words.items():
                word = self._status(slot, number)
                news, last_words[slot, number] = word & ~last_words[slot, number], word
                names += [
                    f"slot {slot}: {named_bit.name}" for named_bit in bits if news >> named_bit.place.bit & 1
                ]
            return ", ".join(names) if names else None

        return met

    def _status(self, slot: int, number: int) -> int:
        """Return a word of status, in configuration mode without the bits that have another meaning."""
        image, names = self._around.image, self._around.words[slot]
        word = image(slot, "I", number)
        configured = names.modes is not None and image(slot, "I", names.modes.input) < 0
        return word & names.live("I", number) if configured else word


def _same(one: Any, other: Any) -> bool:
    return one == other if isinstance(one, (list, dict)) else same(one, other)


_MAKERS: Mapping[str, Callable[[Looker, str], Callable[[int], str | None]]] = {
    "function": Looker._expression,
    "data": Looker._tag,
    "exception": Looker._exception,
}


def described(one: Breakpoint) -> Json:
    """Return a breakpoint as a protocol object."""
    place = {"line": one.line, "source": {"path": one.path}} if one.line else {}
    return {"id": one.number, "verified": one.placed, **place}
