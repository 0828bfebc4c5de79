"""What a networked drive, or another module with two modes, waits for, in the names of its own bits.

in configuration mode    for bit 15 of output word 0 to return to 0
without a configuration  for a valid one
moving                   MOVE_COMPLETE not yet: command, position, target
not enabled              for ENABLE_DRIVER
acknowledging            for the acknowledged command bit to return to 0
a command bit is on      for it to return to 0: a command begins when its bit goes from 0 to 1
idle                     for a command
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from scanrack.io_images.module_words import CONFIGURES, BitPlace
from scanrack.traces.read.number_formats import NumberFormats

from .past import SlotPast, event_text

MOVES = frozenset(
    {
        "ABSOLUTE_MOVE",
        "RELATIVE_MOVE",
        "RESUME_MOVE",
        "FIND_HOME_CW",
        "FIND_HOME_CCW",
        "JOG_CW",
        "JOG_CCW",
        "MANUAL_CW",
        "MANUAL_CCW",
        "RUN_ASSEMBLED_MOVE",
    }
)
"""Command bits of all families that begin a motion."""

CLEARED_BY = {
    "CONFIG_ERROR": "a valid configuration clears it",
    "POSITION_INVALID": "homing or PRESET_POSITION clears it; it takes no absolute move before",
}
"""What clears each error bit; RESET_ERRORS clears all others."""


def drive_waits(past: SlotPast) -> list[str]:
    """Return what a module waits for, as sentences."""
    state = next(state for state_of in _STATES if (state := state_of(past)) is not None)
    return [state, *_errors(past)]


def places_on(past: SlotPast, image: str) -> dict[str, BitPlace]:
    """Return the named bits of an image, "I" or "O", that are on now."""
    words = past.inputs if image == "I" else past.out
    named = (item for names in past.slot.words.groups.values() for item in names.items())
    return {
        name: signal
        for name, signal in named
        if signal.image == image and words[signal.word] >> signal.bit & 1
    }


def _on(past: SlotPast, name: str) -> bool:
    return name in places_on(past, "I")


def _lacks(past: SlotPast, name: str) -> bool:
    """Whether the module has a status bit that is off."""
    return past.slot.words.place(name) is not None and not _on(past, name)


def _number(past: SlotPast, name: str, words: Sequence[int]) -> str:
    """Return a quantity of an image as text; "?" if the module does not have it."""
    quantity, formats = past.slot.words.quantity(name), NumberFormats()
    if quantity is None:
        return "?"
    for event in past.past.events:
        formats.note(event.scan, event.fields)
    return f"{formats.value(past.slot.number, past.past.scan, quantity, words):,}"


def _at(past: SlotPast) -> str:
    return f"at {_number(past, 'position', past.inputs)}"


def _answers_not(past: SlotPast) -> str | None:
    if past.slot.words.configures("I", past.inputs) or not _lacks(past, "MODULE_OK"):
        return None
    return "MODULE_OK is 0: it takes no command"


def _configuring(past: SlotPast) -> str | None:
    words = past.slot.words
    if words.modes is None or not words.configures("I", past.inputs):
        return None
    state = f"in configuration mode{past.since('in', words.modes.input, 1 << CONFIGURES)}"
    if words.configures("O", past.out):
        return f"{state}: the words count once bit 15 of output word 0 goes back to 0; it takes no command"
    return f"{state}: bit 15 of output word 0 is 0, so it leaves with its next update"


def _enters_configuration(past: SlotPast) -> str | None:
    if not past.slot.words.configures("O", past.out):
        return None
    return "bit 15 of output word 0 is 1: it goes into configuration mode with its next update"


def _unconfigured(past: SlotPast) -> str | None:
    return "it waits for a valid configuration" if _on(past, "CONFIG_ERROR") else None


def _moves(past: SlotPast) -> str | None:
    way = next((name[-3:].strip("_") for name in ("MOVING_CW", "MOVING_CCW") if _on(past, name)), None)
    if way is None:
        return None
    how = "".join(f", {name.lower()}" for name in ("ACCELERATING", "DECELERATING") if _on(past, name))
    move = started(past)
    state = f"moving {way}{how}, {_at(past)}"
    if move is None:
        return f"{state}, since before the recording"
    name, row = move
    target = f", its target is {_number(past, 'target', past.words_at('out', row))}"
    end = target if name == "ABSOLUTE_MOVE" else ""
    return f"{state}: {name} since {past.past.when(row)}; MOVE_COMPLETE not yet{end}"


def started(past: SlotPast) -> tuple[str, int] | None:
    """Return the command bit that began the last motion, and its row; None if none is recorded."""
    places = past.slot.words.groups.get("command", {})
    moves = {name: 1 << signal.bit for name, signal in places.items() if name in MOVES}
    begun = (
        (name, row) for row, new in past.rises(sum(moves.values())) for name in moves if new & moves[name]
    )
    return next(begun, None)


def _disabled(past: SlotPast) -> str | None:
    if not _lacks(past, "DRIVE_ENABLED"):
        return None
    return f"at rest {_at(past)}, not enabled: it waits for ENABLE_DRIVER in output word 1"


def _held(past: SlotPast) -> str | None:
    if not _on(past, "HOLD_STATE"):
        return None
    return f"held {_at(past)}: it waits for RESUME_MOVE, or for another move{still_on(past, _commands(past))}"


def _acknowledges(past: SlotPast) -> str | None:
    commands = _commands(past)
    if not _on(past, "ACKNOWLEDGE") or not commands:
        return None
    return f"it has acknowledged {' '.join(commands)}, and waits for it to go back to 0"


def _command_on(past: SlotPast) -> str | None:
    commands = _commands(past)
    return command_on(past, commands, f"at rest {_at(past)}") if commands else None


def _commands(past: SlotPast) -> dict[str, int]:
    """Return the command bits that are on, by name."""
    command, on = past.slot.words.groups.get("command", {}), places_on(past, "O")
    return {name: 1 << signal.bit for name, signal in on.items() if name in command and signal.word == 0}


def command_on(past: SlotPast, commands: Mapping[str, int], rest: str) -> str:
    """Return the state of a module at rest whose command bits are on; `rest` describes it without them."""
    if past.past.last_change(past.slot.number, "out", 0) == past.past.row:
        return f"{' '.join(commands)} with this scan: it takes the command with its next update"
    return f"{rest}{still_on(past, commands)}"


def still_on(past: SlotPast, commands: Mapping[str, int]) -> str:
    """Return a phrase about command bits that are still on; "" if there are none."""
    if not commands:
        return ""
    names, since = " ".join(commands), past.since("out", 0, sum(commands.values()))
    verb = "is" if len(commands) == 1 else "are"
    return f"; {names} {verb} still on{since}: the next command needs a bit that goes from 0 to 1"


def _idle(past: SlotPast) -> str:
    awaited = "RESET_ERRORS" if _on(past, "COMMAND_ERROR") else "a command bit to go from 0 to 1"
    return f"at rest {_at(past)}: it waits for {awaited}"


_STATES: Sequence[Callable[[SlotPast], str | None]] = (
    _answers_not,
    _configuring,
    _enters_configuration,
    _unconfigured,
    _moves,
    _disabled,
    _held,
    _acknowledges,
    _command_on,
    _idle,
)
"""The possible states of a module; the first one that applies counts."""


def _errors(past: SlotPast) -> Iterator[str]:
    words = past.slot.words
    if words.configures("I", past.inputs):
        return  # in configuration mode the bits mirror the configuration
    on = places_on(past, "I")
    for name in (*words.errors, "POSITION_INVALID"):
        if name in on:
            since = past.since("in", on[name].word, 1 << on[name].bit)
            yield f"{name}{since}: {_cause(past, name)}; {CLEARED_BY.get(name, 'RESET_ERRORS clears it')}"


def _cause(past: SlotPast, name: str) -> str:
    """Return the recorded rule that set a bit."""
    for rule in reversed(past.past.rules(past.slot.number)):
        named = rule.fields.get("bits")
        if isinstance(named, list) and name in named:
            return event_text(rule)
    return "no rule is recorded that set it"
