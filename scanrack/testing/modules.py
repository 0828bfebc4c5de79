"""A test kit for authors of modules, which checks the contract in docs/own-module.md.

    from scanrack.testing.modules import check_module, record_in

    def test_the_blinker_keeps_its_contract() -> None:
        check_module(record_in(Path(__file__).with_name("blinker.py")))

Random choices depend only on the seed.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args, get_origin

from scanrack.io_images.image import WORD_MAX, WORD_MIN, WORDS, WORDS_MAX, Image
from scanrack.io_images.module_words import BitPlace, ModuleWords
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.module import Module
from scanrack.runtime.machine import MachineSpec
from scanrack.runtime.modules.record import ModuleRecord, Options

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

STEPS = 12
LONGEST_NS = (2_000_000, 100_000_000, 1_000_000_000)
"""Maximum lengths of a step for a scan, a device's response, or a motion, ns."""

NO_MACHINE = MachineSpec()

Act: TypeAlias = Callable[[Any, int, int], None]
"""A function that acts on a module at the start of a step; its arguments include the step's start and end,
ns."""

Pieces: TypeAlias = Callable[[int, int], Sequence[int]]
"""A function that returns extra times for calls of `update` between the start and end of a step; all in
ns."""

Draw: TypeAlias = Callable[[Random], Sequence[int]]
"""A function that draws output words."""

Shown: TypeAlias = tuple[Sequence[int], Sequence[Event]]
"""The output of a module at an instant: its input words, and its events since the previous instant.

Events of indicators are left out: LEDs are evaluated when `update` is called.
"""


class ContractError(AssertionError):
    """A module violates its contract; the message has the options, the seed and the step."""


@dataclass(frozen=True, slots=True)
class Step:
    """A period with unchanged outputs.

    Attributes:
        wait_ns: length of the period.
        words: the first output words; the others are 0.
        running: whether the controller is in run mode.
        act: acts on the module at its start.
    """

    wait_ns: int
    words: Sequence[int]
    running: bool = True
    act: Act | None = None


def check_module(
    record: ModuleRecord,
    options: Options | None = None,
    *,
    seeds: Sequence[int] = range(25),
    words: Draw | None = None,
    machine: MachineSpec = NO_MACHINE,
) -> None:
    """Check that a module handles any words, repeats its runs, tolerates extra calls and decodes its names.

    Args:
        record: record of the module.
        options: fixed options by name; the others are drawn from their defaults and the ends of their ranges.
        seeds: each seed draws options and a script of a dozen steps.
        words: draws output words that use the module's functions; None = `any_words`.
        machine: the machine that the module moves.

    Raises:
        ContractError: the module violates its contract.
    """
    for seed in seeds:
        drawn = _drawn_options(record, options or {}, Random(seed))
        head = f"{record.name} with options {dict(drawn)}"
        module_words = record.words(drawn)
        _check_names(head, record, module_words)
        output_count, input_count = len(module_words.outputs), len(module_words.inputs)
        script = any_script(seed, words or partial(any_words, size=output_count))
        runs = []
        for pieces in (at_once, at_once, at_random(seed)):
            module = record.make(firmware="4.1", machine=machine, seed=seed, options=drawn, wiring=None)
            try:
                runs.append(play(module, script, pieces, output_count))
            except Exception as error:
                note = " ".join(getattr(error, "__notes__", ()))
                raise ContractError(
                    f"{head}: any words must be survived; seed {seed}: {error!r} {note}"
                ) from error
        first, repeated, in_pieces = runs
        for inputs, _ in first:
            if len(inputs) != input_count:
                raise ContractError(f"{head}: it names {input_count} input words and returns {len(inputs)}")
        _compare(f"{head}: two runs must be equal; seed {seed}", first, repeated)
        _compare(f"{head}: calls between must not matter; seed {seed}", first, in_pieces)


def record_in(path: Path, name: str = "RECORD") -> ModuleRecord:
    """Execute a file and return the record in it; raise `ProgramError` if there is none."""
    from scanrack.jobs.load.program import load_modules

    return load_modules({path.stem: f"{path.name}:{name}"}, path)[path.stem]


def play(module: Module, script: Sequence[Step], pieces: Pieces, size: int = WORDS) -> list[Shown]:
    """Play a script with a new module; return its output at 0 ns and at the end of each step.

    Args:
        size: number of its output words.
    """
    now_ns, outputs = 0, Image(size=size)
    shown = [_shown(module, now_ns, outputs)]
    for number, step in enumerate(script, 1):
        end_ns = now_ns + step.wait_ns
        try:
            module.plc_run(step.running)
            if step.act is not None:
                step.act(module, now_ns, end_ns)
            outputs.load(Image(step.words, size=size))  # in the same memory, as in the scan loop
            for at_ns in pieces(now_ns, end_ns):
                module.update(at_ns, outputs)
            shown.append(_shown(module, end_ns, outputs))
        except Exception as error:
            error.add_note(f"in step {number}, {now_ns} to {end_ns} ns, outputs {list(step.words)}")
            raise
        now_ns = end_ns
    return shown


def at_once(_begin_ns: int, _end_ns: int) -> Sequence[int]:
    """Return no instants, so that `update` is called only at the end."""
    return ()


def every(period_ns: int) -> Pieces:
    """Return a function that divides a step into pieces of equal length."""
    return lambda begin_ns, end_ns: range(begin_ns + period_ns, end_ns, period_ns)


def at_random(seed: int) -> Pieces:
    """Return a function that draws up to five instants of a step, which can include its start and end."""
    dice = Random(seed)

    def pieces(begin_ns: int, end_ns: int) -> Sequence[int]:
        instants = [dice.choice((begin_ns, end_ns, *[dice.randint(begin_ns, end_ns)] * 4)) for _ in range(5)]
        return sorted(instants[: dice.randint(0, 5)])

    return pieces


def any_words(dice: Random, size: int = WORDS) -> Sequence[int]:
    """Draw the output words of an image: zeros, one bit, or words of any value, many of them small."""
    kind = dice.randrange(4)
    if kind == 0:
        return ()
    if kind == 1:
        return [0] * dice.choice((0, 0, min(1, size - 1), dice.randrange(size))) + [1 << dice.randrange(16)]
    ends = (0, 1, WORD_MAX, WORD_MIN)
    return [dice.choice((*ends, dice.randrange(200), dice.randint(WORD_MIN, WORD_MAX))) for _ in range(size)]


def any_script(seed: int, words: Draw = any_words) -> list[Step]:
    """Draw a dozen steps; in some, outputs are unchanged, the controller is not running, or power fails."""
    dice = Random(seed)
    script: list[Step] = []
    for _ in range(STEPS):
        repeats_words = bool(script) and dice.randrange(3) == 0
        script.append(
            Step(
                dice.randint(1, dice.choice(LONGEST_NS)),
                script[-1].words if repeats_words else words(dice),
                running=dice.randrange(8) > 0,
                act=_fail_power if dice.randrange(12) == 0 else None,
            )
        )
    return script


def _fail_power(module: Module, _begin_ns: int, _end_ns: int) -> None:
    module.power_cycle()


def _shown(module: Module, now_ns: int, outputs: Image) -> Shown:
    """Update a module; return its input words and its collected events, and remove these events."""
    words = list(module.update(now_ns, outputs))
    events = tuple(event for event in module.events if event.kind != "indicator")
    module.events.clear()
    return words, events


def _compare(promise: str, first_run: Sequence[Shown], second_run: Sequence[Shown]) -> None:
    """Raise ContractError at the first input word or events that differ between two runs."""
    for step, ((words, events), (words_2, events_2)) in enumerate(zip(first_run, second_run, strict=True)):
        for number, (word, word_2) in enumerate(zip(words, words_2, strict=True)):
            if word != word_2:
                raise ContractError(f"{promise}, step {step}: input word {number} is {word}, then {word_2}")
        if events != events_2:
            raise ContractError(f"{promise}, step {step}: events are {events}, then {events_2}")


def _check_names(head: str, record: ModuleRecord, words: ModuleWords) -> None:
    """Raise ContractError for unusable names of words, or for status bits that do not show their names."""
    for image, names in (("output", words.outputs), ("input", words.inputs)):
        if not 1 <= len(names) <= WORDS_MAX:
            raise ContractError(f"{head}: {len(names)} {image} words have names: must be 1 to {WORDS_MAX}")
        if len(set(names)) != len(names) or not all(map(_is_name, names)):
            raise ContractError(f"{head}: {image} words need different names in small letters: {names}")
    for name, signal in words.groups.get("status", {}).items():
        _check_decoded(f"{head}: slot1.status.{name}", name, signal, record, words)
    for value in (0, -1):
        size = len(words.inputs)
        str(record.status(Image([value] * size, size=size), words))


def _is_name(name: str) -> bool:
    return re.fullmatch(r"[a-z][a-z0-9_]*", name) is not None


def _check_decoded(bit: str, name: str, signal: BitPlace, record: ModuleRecord, words: ModuleWords) -> None:
    """Check that an image with one status bit set shows only the name of that bit."""
    image = Image(size=len(words.inputs))
    image.set_bit(signal.word, signal.bit, True)
    shown = str(record.status(image, words))
    decoded = set(re.findall(r"\w+", shown)) & set(words.groups["status"])
    if signal.image != "I" or decoded != {name}:
        raise ContractError(f"{bit} must decode to its name; {signal} alone is shown as {shown!r}")


def _drawn_options(record: ModuleRecord, fixed: Options, dice: Random) -> Options:
    """Return the fixed and drawn options, or only the fixed ones if the module refuses the drawn ones."""
    if record.option_table is None:
        return fixed
    table = record.option_table()
    ends = {name: _ends(field) for name, field in table.model_fields.items() if name not in fixed}
    drawn: dict[str, Any] = {
        name: dice.choice(values) for name, values in ends.items() if values and dice.randrange(2)
    }
    try:
        table(**fixed, **drawn)
    except ValueError:  # options that exclude each other
        return fixed
    return {**fixed, **drawn}


def _ends(field: FieldInfo) -> Sequence[Any]:
    """Return the ends of an option's range; empty if it has no range."""
    if field.annotation is bool:
        return (False, True)
    if get_origin(field.annotation) is Literal:
        return get_args(field.annotation)
    limits: Mapping[str, Any] = {
        key: getattr(limit, key) for limit in field.metadata for key in ("ge", "le") if hasattr(limit, key)
    }
    return tuple(limits.values())
