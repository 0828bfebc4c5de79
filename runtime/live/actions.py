"""Operator actions on a running rack, as data: checked by the monitor, and again by the session.

    {"do": "press", "slot": 1, "name": "home", "on": true}

An action object is always well formed. The rack checks the slot, tag and input when it applies the action.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import MISSING, asdict, fields
from itertools import chain
from typing import Any, NoReturn, TypeGuard

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.doors import json_value
from scanrack.io_images.image import WORDS_MAX

from ..loop.incidents import FaultKind
from .speeds import MAX, SPEED_LEAST, SPEED_MOST

MOST_STEPS = 1_000_000
SCAN_MOST = (1 << 32) - 1
MOST_EDITS = 1_000_000
TEXT_MOST = 400
"""Longest name or text in an action, in characters."""

STORE_MOST = 5_000
"""Maximum bytes that a `Store` writes: more than a packet contains."""

DRAFT_MOST = 60_000
"""Longest text of a program that a page edits, in bytes of JSON. A message has up to 64 KiB."""

RUNGS_MOST = 200
"""Maximum number of rung texts in a draft. All of them are checked and drawn for the page at once."""

DEEPEST = 8
"""Maximum nesting of lists and objects in a message."""


ALL = "all"
"""Replaces the tag in an action on all forces, or the location in an action on all breakpoints."""


Value = bool | int | float | str


@dataclass(frozen=True, slots=True)
class Action:
    """An operator action."""


@dataclass(frozen=True, slots=True)
class Mode(Action):
    """Turn the controller's key to "run", "program" or "test"."""

    mode: str


@dataclass(frozen=True, slots=True)
class Pause(Action):
    """Stop between two scans."""


@dataclass(frozen=True, slots=True)
class Continue(Action):
    """Continue after a pause."""


@dataclass(frozen=True, slots=True)
class Step(Action):
    """Run a number of scans, then pause."""

    scans: int = 1


@dataclass(frozen=True, slots=True)
class Speed(Action):
    """Run at a multiple of real time, 0.01 to 1,000, or at "max"."""

    factor: float | str


@dataclass(frozen=True, slots=True)
class Press(Action):
    """Hold a module's input on or off; None returns the input to the machine's control."""

    slot: int
    name: str
    on: bool | None
    by: str = ""  # the person or page panel that pressed it; "" if unknown


@dataclass(frozen=True, slots=True)
class Write(Action):
    """Set a tag once."""

    tag: str
    value: Value
    by: str = ""  # see `Press`


@dataclass(frozen=True, slots=True)
class Store(Action):
    """Set bytes of a tag or of a slot's outputs, on behalf of a tag server client."""

    tag: str  # its full name
    offset: int  # first byte in the tag
    data: str  # hexadecimal
    keep: str = ""  # hexadecimal mask of the bits that keep their value, as long as `data`; "" for none
    client: str = ""  # address of the client, after its user if one has logged in
    part: str = ""  # readable path in the tag: `.Steps[2].Time`; "" for all of it


@dataclass(frozen=True, slots=True)
class Force(Action):
    """Hold a tag, or a word or bit of an image, at a value."""

    tag: str
    value: Value


@dataclass(frozen=True, slots=True)
class Unforce(Action):
    """Release a force, or "all"."""

    tag: str


@dataclass(frozen=True, slots=True)
class InjectFault(Action):
    """Inject a module fault now; see `runtime.loop.incidents`."""

    kind: str
    slot: int
    for_ms: float = 0
    late_words: tuple[int, ...] = ()
    state: str = ""  # name of the condition, for a fault of the kind condition


@dataclass(frozen=True, slots=True)
class Breakpoint(Action):
    """Pause when a rung becomes true, changes or executes (`Main.3 executes`), or when a tag changes."""

    at: str


@dataclass(frozen=True, slots=True)
class RemoveBreakpoint(Action):
    """Remove a breakpoint, or "all"."""

    at: str


@dataclass(frozen=True, slots=True)
class Reload(Action):
    """Reload the program's file, and continue with it."""

    restart: str = ""  # sequences that restart, separated by commas; "all" for the whole program


@dataclass(frozen=True, slots=True)
class Edit(Action):
    """Continue with an edited program. The session makes this action itself, with the program's files."""

    number: int  # number of the edit, from 1; its files are in the trace as `edit-NUMBER/...`
    program: str  # path of the program in these files, `path[:function]`
    restart: str = ""  # see `Reload`


@dataclass(frozen=True, slots=True)
class Branch(Action):
    """Begin a new session that repeats this one up to a scan and then continues on its own."""

    scan: int
    paused: bool = False  # whether the new session pauses there


@dataclass(frozen=True, slots=True)
class Source(Action):
    """Request the text of the program's file."""


@dataclass(frozen=True, slots=True)
class Draft(Action):
    """Preview an edited text of the program's file, or save the text and run it."""

    text: str
    base: str  # digest of the text before the edit
    restart: str = ""  # see `Reload`
    take: bool = False  # save the text and run it
    effects: bool = False  # also report every possible effect of the edit, which takes seconds


@dataclass(frozen=True, slots=True)
class Online(Action):
    """Take a step of an online edit: accept, test, untest, assemble, reopen, cancel or save."""

    step: str
    base: str = ""  # accept: digest of the program's file before the edit; later steps: of the edited file
    rungs: tuple[tuple[str, int, tuple[str, ...]], ...] = ()  # routine, number, and replacement rungs
    tags: tuple[tuple[str, str, str], ...] = ()  # new tags: name, type, program
    by: str = ""  # see `Press`


ToEditor = Source | Draft | Online
"""Actions that a session's editor answers while scans continue."""

ACTIONS: Mapping[str, type[Action]] = {
    "mode": Mode,
    "pause": Pause,
    "go": Continue,
    "step": Step,
    "speed": Speed,
    "press": Press,
    "write": Write,
    "force": Force,
    "unforce": Unforce,
    "incident": InjectFault,
    "breakpoint": Breakpoint,
    "unbreak": RemoveBreakpoint,
    "reload": Reload,
    "branch": Branch,
}
"""The actions that a page may send, by name."""

TYPED: Mapping[str, type[Action]] = {"source": Source, "draft": Draft, "online": Online}
"""Actions on the program's text that a page may send, by name. A trace contains only the resulting edits.
"""

RECORDED: Mapping[str, type[Action]] = {**ACTIONS, "edit": Edit, "store": Store}
"""The actions that a trace can contain, by name."""

NAMES: Mapping[type[Action], str] = {kind: name for name, kind in {**RECORDED, **TYPED}.items()}


def _check_keys(action_name: str, keys: Collection[str], defaults: Mapping[str, object]) -> None:
    """Raise a ValueError for an unknown key, or for a missing key that has no default."""
    for key in keys:
        if key not in defaults:
            allowed = ", ".join(defaults) or "no keys"
            raise ValueError(f"{action_name} has no {_shown(key)}; it has {allowed}")
    for key, default in defaults.items():
        if key not in keys and default is MISSING:
            raise ValueError(f"{action_name} needs {key}")


def action_of(message: object, allowed: Mapping[str, type[Action]] = ACTIONS) -> Action:
    """Return the action of a message.

    >>> action_of({"do": "step", "scans": 3})
    Step(scans=3)

    Args:
        allowed: the allowed actions, by name.

    Raises:
        ValueError: the message is not an allowed action.
    """
    if not isinstance(message, Mapping):
        raise ValueError("an action must be an object with the key do")
    name = message.get("do")
    kind = allowed.get(name) if isinstance(name, str) else None
    if kind is None:
        raise ValueError(f"no action {_shown(name)}; choose from {', '.join(allowed)}")
    arguments = {key: value for key, value in message.items() if key != "do"}
    _check_keys(f"{name}", arguments, {field.name: field.default for field in fields(kind)})
    return kind(**{key: _checked(f"{name}", key, value) for key, value in arguments.items()})


def names_in(restart: str) -> tuple[str, ...]:
    """Return the sequence names in an action's `restart` text.

    >>> names_in("cycle, panel"), names_in("")
    (('cycle', 'panel'), ())
    """
    return tuple(name.strip() for name in restart.split(",") if name.strip())


_LEFT_OUT = ("restart", "keep", "client", "part", "by", "paused", "state")
"""Fields that a message omits while they are empty or false."""


def message_of(action: Action) -> dict[str, Any]:
    """Return the message for an action; `action_of` converts it back."""
    message = {"do": NAMES[type(action)], **asdict(action)}
    return {key: value for key, value in message.items() if value or key not in _LEFT_OUT}


def text_of(action: Action) -> str:
    """Return an action as JSON text, as in the trace.

    >>> text_of(Press(1, "home", True))
    '{"do":"press","slot":1,"name":"home","on":true}'
    """
    return json.dumps(message_of(action), ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def parsed(text: str | bytes) -> Any:
    """Return the value of a JSON text.

    Raises:
        ValueError: the text is not JSON, contains NaN or an infinity, is nested more than `DEEPEST` levels
            deep, or contains text that UTF-8 can't encode.
    """
    value = json_value(text, parse_constant=_refuse_constant)
    _refuse_oddities(value)
    return value


def _refuse_oddities(value: object) -> None:
    """Refuse JSON that can't be shown: deep nesting, unpaired surrogates."""
    values = [value]
    for _ in range(DEEPEST + 1):
        for text in values:
            if isinstance(text, str) and not _is_unicode(text):
                raise ValueError(f"{_shown(text)} has half of a surrogate pair")
        values = [member for container in values for member in _inside(container)]
        if not values:
            return
    raise ValueError("it is nested too deep")


def _inside(value: object) -> Iterable[object]:
    """Return the keys and values of a dictionary, or the items of a list; nothing for other values."""
    if isinstance(value, dict):
        return chain(value, value.values())
    return value if isinstance(value, list) else ()


def _is_unicode(text: str) -> bool:
    """Return whether a text has no unpaired surrogates."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not allowed: JSON has no such number")


def _whole(least: int, most: int) -> Callable[[object], bool]:
    return lambda value: type(value) is int and least <= value <= most


def _is_text(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= TEXT_MOST and value.isprintable()


def _is_draft(value: object) -> bool:
    if not isinstance(value, str) or len(value) > DRAFT_MOST or not _is_unicode(value):
        return False
    return len(json.dumps(value, ensure_ascii=False).encode()) <= DRAFT_MOST


def _is_number(value: object) -> bool:
    if type(value) is int:
        return abs(value) < 1 << 64
    return isinstance(value, float) and math.isfinite(value)


def _is_value(value: object) -> bool:
    if isinstance(value, str):
        return len(value) <= TEXT_MOST and _is_unicode(value)
    return isinstance(value, bool) or _is_number(value)


def _is_speed(value: object) -> bool:
    return value == MAX or (_is_number(value) and SPEED_LEAST <= value <= SPEED_MOST)  # type: ignore[operator]


def _are_words(value: object) -> bool:
    if not isinstance(value, (list, tuple)) or len(value) > WORDS_MAX:
        return False
    return all(map(_whole(0, WORDS_MAX - 1), value))


def _is_hex(value: object) -> bool:
    if not isinstance(value, str) or len(value) > 2 * STORE_MOST or len(value) % 2:
        return False
    return all(digit in "0123456789abcdef" for digit in value)


def _are_rungs(value: object) -> bool:
    if not _is_short(value) or not all(map(_is_rung, value)):
        return False
    return sum(len(texts) for _routine, _number, texts in value) <= RUNGS_MOST


def _is_rung(value: object) -> bool:
    """Return whether a value is a routine, a rung number and the texts that replace that rung.

    Rung -1 is the place before the first rung. Without texts the rung is deleted.
    """
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        return False
    routine, number, texts = value
    if not _is_text(routine) or not _whole(-1, MOST_EDITS)(number) or not isinstance(texts, (list, tuple)):
        return False
    return all(isinstance(text, str) and text.isprintable() for text in texts)


def _are_tags(value: object) -> bool:
    return _is_short(value) and all(
        isinstance(tag, (list, tuple)) and list(map(type, tag)) == [str] * 3 and "".join(tag).isprintable()
        for tag in value
    )


def _is_short(value: object) -> TypeGuard[Sequence[Any]]:
    """Return whether a value is a list within the size limit of a draft."""
    if not isinstance(value, (list, tuple)):
        return False
    return len(json.dumps(value, ensure_ascii=False).encode()) <= DRAFT_MOST


def _frozen(value: object) -> Any:
    return tuple(map(_frozen, value)) if isinstance(value, (list, tuple)) else value


STEPS = ("accept", "test", "untest", "assemble", "reopen", "cancel", "save")
_KINDS = tuple(kind.value for kind in FaultKind if kind is not FaultKind.PROGRAM_MODE)
_MODES = ("run", "program", "test")
_TEXT = f"text of 1 to {TEXT_MOST} printable characters"
_OPTIONAL = (lambda value: value == "" or _is_text(value), _TEXT)
_FLAG = (lambda value: isinstance(value, bool), "true or false")
_HEX = f"up to {STORE_MOST:,} bytes as hexadecimal digits"

_ALLOWED: Mapping[str, tuple[Callable[[object], bool], str]] = {
    "mode": (lambda value: value in _MODES, ", ".join(_MODES)),
    "scans": (_whole(1, MOST_STEPS), f"1 to {MOST_STEPS:,}"),
    "scan": (_whole(0, SCAN_MOST), "the number of a scan"),
    "factor": (_is_speed, f"{SPEED_LEAST} to {SPEED_MOST:g}, or {MAX}"),
    "slot": (_whole(1, 1 << 16), "the number of a slot"),
    "number": (_whole(1, MOST_EDITS), f"1 to {MOST_EDITS:,}"),
    "program": (_is_text, _TEXT),
    "restart": _OPTIONAL,
    "name": (_is_text, _TEXT),
    "text": (_is_draft, f"text of up to {DRAFT_MOST:,} bytes"),
    "base": _OPTIONAL,
    "step": (lambda value: value in STEPS, ", ".join(STEPS)),
    "rungs": (_are_rungs, f"[routine, number, texts], up to {RUNGS_MOST} texts and {DRAFT_MOST:,} bytes"),
    "tags": (_are_tags, "a list of [name, type, program]"),
    "effects": _FLAG,
    "paused": _FLAG,
    "take": _FLAG,
    "on": (lambda value: value is None or isinstance(value, bool), "true, false or null"),
    "tag": (_is_text, _TEXT),
    "at": (_is_text, _TEXT),
    "value": (_is_value, f"true, false, a number, or text of up to {TEXT_MOST} characters"),
    "kind": (lambda value: value in _KINDS, ", ".join(_KINDS)),
    "for_ms": (lambda value: _is_number(value) and 0 <= value <= 1e9, "0 to 1,000,000,000"),  # type: ignore[operator]
    "offset": (_whole(0, (1 << 32) - 1), "the number of a byte"),
    "data": (_is_hex, _HEX),
    "keep": (_is_hex, _HEX),
    "client": _OPTIONAL,
    "part": _OPTIONAL,
    "by": _OPTIONAL,
    "state": _OPTIONAL,
    "late_words": (_are_words, f"a list of words from 0 to {WORDS_MAX - 1}"),
}
"""By field name, the function that checks the field, and its allowed values as text for a message."""


def _checked(action_name: str, key: str, value: object) -> Any:
    """Return a field's value with lists converted to tuples; raise ValueError if it is not allowed."""
    is_allowed, allowed = _ALLOWED[key]
    if not is_allowed(value):
        raise ValueError(f"{action_name}: {key} {_shown(value)} is not allowed: {allowed}")
    return _frozen(value)


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
