"""Describes waits of a networked drive, or of another module with two modes, by its bit names.

in configuration mode    for bit 15 of output word 0 to return to 0
without a configuration  for a valid configuration
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
    "POSITION_INVALID": "homing or PRESET_POSITION clears it; until then it refuses absolute moves",
}
"""What clears each error bit; RESET_ERRORS clears all others."""


def drive_waits(past: SlotPast) -> list[str]:
    """Return what a module is waiting for, as sentences."""
    state = next(state for state_of in _STATES if (state := state_of(past)) is not None)
    return [state, *_errors(past)]


def places_on(past: SlotPast, image: str) -> dict[str, BitPlace]:
    """Return the named bits of an image, "I" or "O", that are on now."""
    words = past.inputs if image == "I" else past.out
    return {
        name: signal
        for names in past.slot.words.groups.values()
        for name, signal in names.items()
        if signal.image == image and words[signal.word] >> signal.bit & 1
    }


def _on(past: SlotPast, name: str) -> bool:
    return name in places_on(past, "I")


def _lacks(past: SlotPast, name: str) -> bool:
    """Return whether the module has a status bit that is off."""
    return past.slot.words.place(name) is not None and not _on(past, name)


def _quantity_text(past: SlotPast, name: str, words: Sequence[int]) -> str:
    """Return a quantity of an image as text; "?" if the module has no such quantity."""
    quantity, formats = past.slot.words.quantity(name), NumberFormats()
    if quantity is None:
        return "?"
    for event in past.past.events:
        formats.note(event.scan, event.fields)
    return f"{formats.value(past.slot.number, past.past.scan, quantity, words):,}"


def _position_text(past: SlotPast) -> str:
    return f"at {_quantity_text(past, 'position', past.inputs)}"


# --- the states: each function describes one of them, and returns None in any other


def _not_ok(past: SlotPast) -> str | None:
    if past.slot.words.configures("I", past.inputs) or not _lacks(past, "MODULE_OK"):
        return None
    return "MODULE_OK is 0: it accepts no command"


def _configuring(past: SlotPast) -> str | None:
    """Describe configuration mode: whether the program or the module must end it."""
    words = past.slot.words
    if words.modes is None or not words.configures("I", past.inputs):
        return None
    state = f"in configuration mode{past.since('in', words.modes.input, 1 << CONFIGURES)}"
    if words.configures("O", past.out):
        return (
            f"{state}: it uses the words when bit 15 of output word 0 goes back to 0, and accepts no command"
        )
    return f"{state}: bit 15 of output word 0 is 0, so it leaves with its next update"


def _enters_configuration(past: SlotPast) -> str | None:
    if not past.slot.words.configures("O", past.out):
        return None
    return "bit 15 of output word 0 is 1: it enters configuration mode with its next update"


def _unconfigured(past: SlotPast) -> str | None:
    return "it waits for a valid configuration" if _on(past, "CONFIG_ERROR") else None


def _moving(past: SlotPast) -> str | None:
    """Describe the current motion: direction, position, and the command that began it with its target."""
    direction = next((way for way in ("CW", "CCW") if _on(past, f"MOVING_{way}")), None)
    if direction is None:
        return None
    rate = "".join(f", {name.lower()}" for name in ("ACCELERATING", "DECELERATING") if _on(past, name))
    start = started(past)
    state = f"moving {direction}{rate}, {_position_text(past)}"
    if start is None:
        return f"{state}, since before the recording"
    row, mask = start
    name = next(name for name, bit in _moves_of(past).items() if bit & mask)
    target = f", its target is {_quantity_text(past, 'target', past.words_at('out', row))}"
    end = target if name == "ABSOLUTE_MOVE" else ""
    return f"{state}: {name} since {past.past.when(row)}; MOVE_COMPLETE not yet{end}"


def started(past: SlotPast) -> tuple[int, int] | None:
    """Return the row in which the last motion began, and its command bit; None if none is recorded."""
    moves = _moves_of(past).values()
    starts = ((row, move) for row, bits in past.rises(sum(moves)) for move in moves if bits & move)
    return next(starts, None)


def _moves_of(past: SlotPast) -> dict[str, int]:
    """Return the command bits of a module that begin a motion, by name."""
    places = past.slot.words.groups.get("command", {})
    return {name: 1 << signal.bit for name, signal in places.items() if name in MOVES}


def _disabled(past: SlotPast) -> str | None:
    if not _lacks(past, "DRIVE_ENABLED"):
        return None
    return f"at rest {_position_text(past)}, not enabled: it waits for ENABLE_DRIVER in output word 1"


def _on_hold(past: SlotPast) -> str | None:
    if not _on(past, "HOLD_STATE"):
        return None
    on = still_on(past, _commands(past))
    return f"held {_position_text(past)}: it waits for RESUME_MOVE, or for another move{on}"


def _acknowledges(past: SlotPast) -> str | None:
    commands = _commands(past)
    if not _on(past, "ACKNOWLEDGE") or not commands:
        return None
    return f"it has acknowledged {' '.join(commands)}, and waits for it to go back to 0"


def _command_on(past: SlotPast) -> str | None:
    commands = _commands(past)
    return command_on(past, commands, f"at rest {_position_text(past)}") if commands else None


def _commands(past: SlotPast) -> dict[str, int]:
    """Return the command bits that are on, by name."""
    command, on = past.slot.words.groups.get("command", {}), places_on(past, "O")
    return {name: 1 << signal.bit for name, signal in on.items() if name in command and signal.word == 0}


def command_on(past: SlotPast, commands: Mapping[str, int], rest: str) -> str:
    """Return the state of a module at rest with command bits on; `rest` describes it without these bits."""
    if past.past.last_change(past.slot.number, "out", 0) == past.past.row:
        return f"{' '.join(commands)} with this scan: it accepts the command with its next update"
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
    return f"at rest {_position_text(past)}: it waits for {awaited}"


_STATES: Sequence[Callable[[SlotPast], str | None]] = (
    _not_ok,
    _configuring,
    _enters_configuration,
    _unconfigured,
    _moving,
    _disabled,
    _on_hold,
    _acknowledges,
    _command_on,
    _idle,
)
"""The possible states of a module; the first one that applies counts."""


def _errors(past: SlotPast) -> Iterator[str]:
    """Yield each error bit that is on: since when, the rule that set it, and what clears it."""
    words = past.slot.words
    if words.configures("I", past.inputs):
        return  # in configuration mode the bits mirror the configuration
    on = places_on(past, "I")
    for name in (*words.errors, "POSITION_INVALID"):
        if name in on:
            since = past.since("in", on[name].word, 1 << on[name].bit)
            cure = CLEARED_BY.get(name, "RESET_ERRORS clears it")
            yield f"{name}{since}: {_recorded_rule(past, name)}; {cure}"


def _recorded_rule(past: SlotPast, name: str) -> str:
    """Return the recorded rule that set a bit."""
    for rule in reversed(past.past.rules(past.slot.number)):
        bit_names = rule.fields.get("bits")
        if isinstance(bit_names, list) and name in bit_names:
            return event_text(rule)
    return "no rule is recorded that set it"
