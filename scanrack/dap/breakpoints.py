"""An editor's breakpoints, checked after each live or repeated scan.

| kind | stop |
|---|---|
| line | the rung runs and its condition is true; with `becomes true` or `changes`, its power does so |
| function | `Main.3` as a line; `Feeding changes`; any other text is an expression that becomes true |
| data | the value of a tag changes |
| exception | an error bit comes on, a rule of the manual acts, the CPU faults, a scan begins |

Expressions use the values at the end of the scan, because a scan always runs to completion before a stop.
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
from scanrack.ladder.python.line_marks import Observer
from scanrack.ladder.state.memory import same
from scanrack.watch.monitors.troubles import ErrorBit, error_bits

from .conditions import EngineValues, ExpressionError, NamedValues, Read, ScanContext, Values, compiled
from .protocol import DebugError, Json

BECOMES_TRUE, CHANGES = "becomes true", "changes"
"""Conditions of a rung that test the power after its last instruction."""

FILTERS: Mapping[str, tuple[str, str]] = {
    "error": ("Error bits", "An error bit of a module comes on."),
    "rule": ("Rules of the manual", "A rule of the manual acts, such as a refused command."),
    "fault": ("Faults", "The controller faults."),
    "scan": ("Each scan", "A scan begins; with a condition such as `time > 2 s`."),
}
"""Label and description of each exception breakpoint, by id."""

_HIT_COUNT = re.compile(r"(?P<sign>>=|>|<=|<|==|=|%)?\s*(?P<number>\d{1,9})")
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
    """Return the tag in an expression such as `Level changes`; "" for any other expression."""
    head, _, tail = text.rpartition(" ")
    return head.strip() if tail.lower() == CHANGES else ""


@dataclass(slots=True)
class Breakpoint:
    """A breakpoint of an editor."""

    number: int  # its id in the protocol
    kind: str  # line, function, data or exception
    name: str  # the function, the tag or the filter; for a line its file and number
    keys: tuple[LineKey, ...] = ()  # the rungs of a line
    condition: str = ""
    hits: str = ""  # hit count such as `>= 5` or `% 3`; `5` is the same as `>= 5`
    log: str = ""  # message of a log point, with expressions in braces
    line: int = 0  # from 1; 0 without a line
    path: str = ""
    count: int = 0  # hits so far

    @property
    def placed(self) -> bool:
        """Whether the breakpoint does not need a line, or its line is in the running program."""
        return bool(self.keys) or not self.path

    @property
    def power_condition(self) -> str:
        """`BECOMES_TRUE` or `CHANGES` for a stop on the power of a rung; "" for other conditions."""
        condition = self.condition.strip().lower()
        return condition if self.keys and condition in (BECOMES_TRUE, CHANGES) else ""

    @property
    def changing_tag(self) -> str:
        """The tag whose change stops execution; "" for any other breakpoint."""
        return self.name if self.kind == "data" else tag_that_changes(self.name)

    def count_hit(self) -> bool:
        """Count a hit; return whether it stops execution."""
        self.count += 1
        match = _HIT_COUNT.fullmatch(self.hits.strip()) if self.hits else None
        return match is None or _SIGNS[match["sign"] or ">="](self.count, int(match["number"]))

    def check_hits(self) -> None:
        """Refuse a hit count that can't be read."""
        if self.hits and _HIT_COUNT.fullmatch(self.hits.strip()) is None:
            raise DebugError(f"hit count {self.hits!r}: must be a number, or one after >=, >, <=, <, = or %")


class Hit(NamedTuple):
    """A breakpoint that was hit."""

    breakpoint: Breakpoint
    text: str


Event = tuple[str, Mapping[str, Any]]
"""Topic and fields of an event; see `traces.format.topics`."""


Check = Callable[[int], str | None]
"""A function called after each scan with its number; returns a text if a breakpoint is hit, else None."""


class ScanValues(Values, Protocol):
    """The values of a program after a scan, and checks of the lines that ran in it."""

    in_frames: bool
    """Whether conditions and log points of lines are evaluated before the line."""

    def line_check(self, requested: Breakpoint) -> Check:
        """Return the check for a breakpoint on lines."""


class RungValues(EngineValues):
    """`ScanValues` of a ladder program."""

    in_frames = False

    def line_check(self, requested: Breakpoint) -> Check:
        """See `ScanValues`; the check is whether a rung ran, or how its power changed."""
        keys, power_condition, ran = requested.keys, requested.power_condition, self.engine.ran
        if not power_condition:
            return lambda _scan: "the rung runs" if any(map(ran, keys)) else None
        last_power: dict[LineKey, bool | None] = dict.fromkeys(keys)

        def met(_scan: int) -> str | None:
            """Return a text if the power of a rung has changed in the requested way since the last scan."""
            text = None
            for key in keys:
                last, power = last_power[key], self._power(key)
                last_power[key] = power
                has_changed = last is not None and power != last
                if has_changed and (power or power_condition == CHANGES):
                    text = f"the rung becomes {'true' if power else 'false'}"
            return text

        return met

    def _power(self, key: LineKey) -> bool:
        """Return whether power reached the end of a rung, after its last instruction."""
        engine = self.engine
        if engine.watching or engine.broken_off:
            truth = engine.truths.get(key, ())
            return bool(truth) and truth[-1]
        return engine.true_at_end(key)


class LinePoints(NamedValues, Observer):
    """Breakpoints on lines of Python or of a list of steps.

    Args:
        in_frames: conditions and log points are Python expressions that read the values before the line.
    """

    def __init__(self, tags: Mapping[str, Any], *, in_frames: bool) -> None:
        super().__init__(tags)
        self.in_frames = in_frames
        self.lines: set[int] = set()
        self._points: dict[LineKey, list[Callable[[FrameType | None], None]]] = {}
        self._met: dict[int, str] = {}  # texts of the breakpoints met in this scan, by their number

    def line_check(self, requested: Breakpoint) -> Check:
        """See `ScanValues`."""
        condition, log = None, list[str | CodeType]()
        if self.in_frames:
            condition = _code(requested.condition) if requested.condition.strip() else None
            parts = enumerate(_FIELD.split(requested.log))  # every second part was in braces
            log = [_code(part) if number % 2 else part for number, part in parts]
        number, text = requested.number, f"line {requested.line} runs"

        def look(frame: FrameType | None) -> None:
            if number not in self._met and (condition is None or _evaluate(condition, frame, False)):
                texts = (part if isinstance(part, str) else str(_evaluate(part, frame, "?")) for part in log)
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


def _evaluate(code: CodeType, frame: FrameType | None, default: object) -> Any:
    """Return the value of an expression in a frame, or `default` if it can't be evaluated."""
    assert frame is not None, "a step has no expressions of Python"
    try:
        return eval(code, frame.f_globals, frame.f_locals)
    except Exception:  # the user's expression may raise anything, for example if a name is not set yet
        return default


@dataclass(slots=True)
class _CheckedBreakpoint:
    """A breakpoint with its check, its compiled condition and its message."""

    breakpoint: Breakpoint
    met: Check
    condition: Read | None
    log: list[str | Read] = field(default_factory=list)  # texts, and compiled expressions


class Looker:
    """Checks the breakpoints after each scan of an engine.

    Args:
        events: function that returns the events of a scan.

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

    def note_values(self, scan: int) -> None:
        """Record the current values as the previous scan's values; the power of rungs is not known yet."""
        for check in self._checks:
            if not check.breakpoint.keys:
                check.met(scan)

    def look(self, scan: int) -> list[tuple[_CheckedBreakpoint, str]]:
        """Return the breakpoints that the latest scan has hit, regardless of their hit counts."""
        checks = []
        for check in self._checks:
            text = check.met(scan)
            if text is not None and (check.condition is None or check.condition()):
                checks.append((check, text))
        return checks

    def hits(self, scan: int) -> list[Hit]:
        """Return the breakpoints that the latest scan has hit; hit counts and log points have no effect."""
        return [Hit(check.breakpoint, text) for check, text in self.look(scan)]

    def stops(self, scan: int, say: Callable[[Breakpoint, str], object]) -> list[Hit]:
        """Return the breakpoints that stop execution in the latest scan; count hits, and print log points."""
        hits = []
        for check, text in self.look(scan):
            if not check.breakpoint.count_hit():
                continue
            if check.breakpoint.log:
                parts = (part if isinstance(part, str) else shown(part()) for part in check.log)
                say(check.breakpoint, visible("".join(parts) or text))
            else:
                hits.append(Hit(check.breakpoint, text))
        return hits

    # --- one check for each breakpoint

    def _check(self, requested: Breakpoint) -> _CheckedBreakpoint:
        """Return a breakpoint with its check, and with its compiled condition and message."""
        if requested.keys:
            met = self._values.line_check(requested)
            if self._values.in_frames:  # the check evaluates condition and message itself
                return _CheckedBreakpoint(requested, met, None)
        else:
            met = _CHECKS.get(requested.kind, Looker._expression_check)(self, requested.name)
        has_expression = requested.condition and not requested.power_condition
        condition = self._compiled(requested.condition) if has_expression else None
        return _CheckedBreakpoint(requested, met, condition, self._log(requested.log))

    def _compiled(self, text: str) -> Read:
        return compiled(text, self._values, self._around)

    def _log(self, text: str) -> list[str | Read]:
        """Return the texts and compiled expressions of a log message; an empty list for an empty message."""
        parts: list[str | Read] = []
        for number, part in enumerate(_FIELD.split(text)):
            parts.append(self._compiled(part) if number % 2 else part)
        return parts if text else []

    def _tag_check(self, name: str) -> Check:
        """Return a check of whether the value of a tag has changed since the last scan."""
        tags = self._values.tags
        if name not in tags:
            raise ExpressionError(f"no tag {name}")
        try:
            read = self._compiled(name)
        except ExpressionError:  # an array or a structure
            read = lambda: tags[name]  # noqa: E731
        no_value: Any = object()  # before the first scan
        value = no_value

        def met(_scan: int) -> str | None:
            nonlocal value
            last_value, value = value, read()
            if last_value is no_value or _same(last_value, value):
                return None
            return f"{name} was {shown(last_value)} and is {shown(value)}"

        return met

    def _expression_check(self, text: str) -> Check:
        """Return a check of whether an expression becomes true, or a tag changes for `TAG changes`."""
        if tag := tag_that_changes(text):
            return self._tag_check(tag)
        read = self._compiled(text)
        is_true = True  # an expression that is true from the first scan does not become true

        def met(_scan: int) -> str | None:
            nonlocal is_true
            was_true, is_true = is_true, bool(read())
            return f"{text} becomes true" if is_true and not was_true else None

        return met

    def _exception_check(self, name: str) -> Check:
        """Return the check of an exception filter: each scan, error bits, rules or faults."""
        if name == "scan":
            return lambda scan: f"scan {scan:,} begins"
        if name == "error":
            return self._error_check()
        topic, kind = ("/events", "rule") if name == "rule" else ("/faults", None)  # faults have no kind

        def met(scan: int) -> str | None:
            texts = [
                str(fields.get("text", ""))
                for event_topic, fields in self._events(scan)
                if event_topic == topic and fields.get("kind") == kind
            ]
            return "; ".join(texts) if texts else None

        return met

    def _error_check(self) -> Check:
        """Return a check of whether error bits have come on since the last scan."""
        bits_of_words: dict[tuple[int, int], list[ErrorBit]] = {}
        for _row, bit in error_bits(self._around.words):
            bits_of_words.setdefault((bit.slot, bit.place.word), []).append(bit)
        last_words = dict.fromkeys(bits_of_words, -1)  # in the first scan, no bit counts as new

        def met(_scan: int) -> str | None:
            names = []
            for (slot, number), bits in bits_of_words.items():
                word = self._status(slot, number)
                new_bits, last_words[slot, number] = word & ~last_words[slot, number], word
                names += [f"slot {slot}: {bit.name}" for bit in bits if new_bits >> bit.place.bit & 1]
            return ", ".join(names) if names else None

        return met

    def _status(self, slot: int, number: int) -> int:
        """Return a status word; in configuration mode, without the bits that have another meaning there."""
        image, names = self._around.image, self._around.words[slot]
        word = image(slot, "I", number)
        is_configuring = names.modes is not None and image(slot, "I", names.modes.input) < 0
        return word & names.live("I", number) if is_configuring else word


def _same(value: Any, other: Any) -> bool:
    return value == other if isinstance(value, (list, dict)) else same(value, other)


_CHECKS: Mapping[str, Callable[[Looker, str], Check]] = {
    "function": Looker._expression_check,
    "data": Looker._tag_check,
    "exception": Looker._exception_check,
}


def described(point: Breakpoint) -> Json:
    """Return a breakpoint as a protocol object."""
    source = {"line": point.line, "source": {"path": point.path}} if point.line else {}
    return {"id": point.number, "verified": point.placed, **source}
