"""Rules about axis commands, in any language, that a 3601 refuses in any state.

Limits and rule texts come from `io_images.amci3601`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from operator import attrgetter

from scanrack.io_images.amci3601 import Configuration, InputBit
from scanrack.io_images.amci3601.rules import RULES
from scanrack.runtime.config.rackspec import SlotSpec
from scanrack.runtime.kinematics import MILLI, PICO
from scanrack.runtime.kinematics.shape import Shape, stopping_distance
from scanrack.runtime.machine import MachineSpec
from scanrack.runtime.machine.spec import input_name

from ..facts import Access, Command, Role, Touch, Violation
from ..logic import base_of
from ..module_kinds import FROM_STARTING_SPEED, allowed
from ..ranges import Range
from ..subject import Subject

MOTIONS = ("home", "move_to", "move_by", "run", "register", "run_blend", "gear")
"""Commands that move an axis."""

ENDING = ("home", "move_to", "move_by", "register", "run_blend")
"""Motions that end by themselves."""

AT_START = ("configure", "home", "set_position", "program_blend", "store_minimum", "gear", "captured")
"""Commands that a program may legitimately send only once."""


def out_of_range(subject: Subject) -> Iterator[Violation]:
    """Find arguments that no module accepts, and speeds below the starting speed."""
    for command in subject.facts.commands:
        problem = _beyond_range(subject, command) or _wrong_direction(command) or _too_slow(subject, command)
        if problem:
            yield Violation(command.place, f"{command.text}: {problem}")


def _beyond_range(subject: Subject, command: Command) -> str:
    """Return a message about the first argument out of range; "" if all are in range or unknown."""
    limits = allowed(command.kind, subject.profile(command.slot).limits)
    for name in filter(limits.__contains__, command.values):
        least, most = limits[name]
        for value in _possible(command, name):
            if value.outside(least, most):
                return f"{name} is {value}: must be {least} to {most}"
    return ""


def _wrong_direction(command: Command) -> str:
    """Return a message about a direction other than 1 or -1; "" if the direction is legal or unknown."""
    direction = command.value("direction")
    if direction.is_constant and abs(direction.least) != 1:
        return f"direction is {direction}: must be 1 (clockwise) or -1 (counterclockwise)"
    return ""


def _possible(command: Command, name: str) -> list[Range]:
    """Return the possible values of an argument; 0 only if it is the only value.

    A program writes 0 to clear the word between commands.
    """
    choices = [choice for choice in command.choices.get(name, ()) if choice.least or choice.most]
    return choices if len(choices) > 1 else [command.value(name)]


def _too_slow(subject: Subject, command: Command) -> str:
    """Return a message about a speed below the starting speed of every configuration; "" if none is."""
    starting_speeds = (configuration.starting_speed for configuration in subject.configurations(command.slot))
    lowest = min(starting_speeds, default=0)
    speeds = _possible(command, "speed") if command.kind in FROM_STARTING_SPEED else []
    most = subject.profile(command.slot).limits.speed
    for speed in speeds if all(value.most < most for value in speeds) else ():
        if speed.most < lowest:
            return f"speed {speed} is below the starting speed, {lowest}"
    return ""


def refused(subject: Subject) -> Iterator[Violation]:
    """Find commands that the module refuses with every configuration of the program."""
    for command in subject.facts.commands:
        configurations = subject.configurations(command.slot)
        rules = [_refusal(command, configuration) for configuration in configurations]
        if rules and all(rules):
            yield Violation(command.place, f"{command.text}: {RULES[rules[0]].text}")


def _refusal(command: Command, configuration: Configuration) -> str:
    """Return the rule of the manual that a command breaks; "" if it breaks no rule that is checked here."""
    if command.kind == "home":
        direction = command.value("direction")
        limit = InputBit.CW_LIMIT if direction.least > 0 else InputBit.CCW_LIMIT
        if direction.is_constant and not configuration.inputs_used & limit:
            return "HOM-03"
    if command.kind == "gear" and not configuration.quadrature_encoder:
        return "CMD-29"
    if command.kind == "register" and _stops_too_late(command, configuration.starting_speed):
        return "PRF-13"
    return ""


def _stops_too_late(command: Command, starting_speed: int) -> bool:
    """Whether the longest registration distance is shorter than the shortest stopping distance."""
    distance, speed, rate = (command.value(name) for name in ("register", "speed", "deceleration"))
    if not (distance.is_known and speed.is_constant and rate.is_known and rate.most >= 1):
        return False
    stop = stopping_distance(MILLI * int(abs(speed.least)), starting_speed, int(rate.most), Shape.CONSTANT)
    return distance.most * PICO < stop


def without_configuration(subject: Subject) -> Iterator[Violation]:
    """Find axes that move before they are configured, or that are never configured."""
    for commands in subject.by_axis():
        first = _first_closed(subject, commands, MOTIONS)
        configuring = [command for command in commands if command.kind == "configure"]
        if first is None:
            continue
        if not configuring and not _is_sent(subject, first):
            text = f"{first.text}: nothing configures {first.axis}, and {RULES['CER-01'].text}"
            yield Violation(first.place, text)
        ordered = [command for command in configuring if command.order]
        motions = [command for command in commands if command.kind in MOTIONS]
        for motion, configuration in first_before(ordered, motions):
            text = f"{motion.text} comes before the configuration in line {configuration.place.line}"
            yield Violation(motion.place, text)


def _first_closed(subject: Subject, commands: Sequence[Command], kinds: Collection[str]) -> Command | None:
    """Return the first command of the kinds; None if commands that are not analyzed may reach the axis."""
    first = next((command for command in commands if command.kind in kinds), None)
    return None if first is None or is_open(subject, first) else first


def first_before(needed: Sequence[Command], commands: Sequence[Command]) -> Iterator[tuple[Command, Command]]:
    """Yield the first command that comes too early, that is, before all needed commands of its sequence.

    Yields at most one pair: the early command, and the first needed command.
    """
    if len({command.owner for command in needed}) != 1 or not all(command.order for command in needed):
        return
    first = min(needed, key=attrgetter("order"))
    early = [
        command
        for command in commands
        if command.sure and command.owner == first.owner and 0 < command.order < first.order
    ]
    if early:
        yield min(early, key=attrgetter("order")), first


def _is_sent(subject: Subject, command: Command) -> bool:
    """Whether the program sends the module's configuration as words."""
    return command.words and any(sent.slot == command.slot for sent in subject.facts.configurations)


def is_open(subject: Subject, command: Command) -> bool:
    """Whether commands that are not analyzed may reach the axis."""
    facts = subject.facts
    is_unknown = facts.reads_all or not command.axis or command.axis in facts.escaped
    return is_unknown or (command.words and command.slot in facts.computed)


def without_position(subject: Subject) -> Iterator[Violation]:
    """Find absolute moves of axes that never home and never have their position set."""
    for commands in subject.by_axis():
        first = _first_closed(subject, commands, ("move_to",))
        positioning = [command for command in commands if command.kind in ("home", "set_position")]
        if first is not None and not positioning:
            text = "needs a valid position, but nothing searches for home or sets the position"
            yield Violation(first.place, f"{first.text} {text}")
        moves = [command for command in commands if command.kind == "move_to"]
        for move, later in first_before(positioning, moves) if first is not None else ():
            order = f"it comes before {later.text} in line {later.place.line}"
            rule = f"{RULES['CMD-06'].text.rstrip('.')} [{RULES['CMD-06'].section}]"
            yield Violation(move.place, f"{move.text} needs a valid position, but {order}: {rule}")


def interrupted(subject: Subject) -> Iterator[Violation]:
    """Find motions that begin before the previous one is complete."""
    for commands in subject.by_axis():
        motions = [command for command in commands if command.kind in MOTIONS and command.execute]
        for index, motion in enumerate(motions):
            for earlier in motions[:index]:
                if _start_together(earlier, motion):
                    text = f"{motion.text} aborts {earlier.text} of line {earlier.place.line}"
                    yield Violation(motion.place, f"{text}: both start in one scan")
        for motion in motions:
            busy = _busy_at_start(subject, motion, motions)
            if busy is not None:
                text = f"{motion.text} aborts {busy.text} of line {busy.place.line}, which is still in motion"
                yield Violation(motion.place, text)


def _start_together(first: Command, second: Command) -> bool:
    """Whether the same bit, or the same condition of bits and steps, starts two blocks."""
    is_same_bit = first.execute == second.execute and second.execute != "1"
    return is_same_bit or bool(second.starts and first.starts == second.starts)


def _busy_at_start(subject: Subject, command: Command, motions: Sequence[Command]) -> Command | None:
    """Return the motion whose Busy or Active bit starts a command; None if no such bit starts it."""
    starting = {command.execute.upper(), *_needed_by(subject, command.execute)}
    for other in motions:
        name = other.text.partition(" ")[2].upper()
        if other is not command and other.kind in ENDING and starting & {f"{name}.BUSY", f"{name}.ACTIVE"}:
            return other
    return None


def _needed_by(subject: Subject, bit: str) -> Iterator[str]:
    """Yield the bits that must be on when a coil or latch switches a bit on."""
    tag = bit.partition(".")[0].partition("[")[0]
    for access in subject.by_key.get(tag, ()):
        if access.use in (Touch.COIL, Touch.LATCH) and f"{access.variable}{access.part}" == bit:
            yield from (base_of(needed.name) for needed in access.needs if needed.on)


def beyond_limits(subject: Subject) -> Iterator[Violation]:
    """Find absolute moves beyond a limit switch, for axes that get their position from a home switch.

    The home search ends at one end of the home switch's range. The position is 0 there.
    """
    for _, slot in subject.steppers:
        commands = [command for command in subject.facts.commands if command.slot == slot.number]
        home = _home_range(slot.machine)
        if home is None or not _is_positioned_by_home(commands, subject.configurations(slot.number)):
            continue
        for move in commands:
            if move.kind == "move_to":
                yield from _beyond_limit(subject, slot, move, home)


def _home_range(machine: MachineSpec) -> tuple[float, float] | None:
    """Return the ends of the only home switch; None if there is not exactly one, or if its range is open."""
    homes = [switch for switch in machine.switches if switch.input == InputBit.HOME]
    if len(homes) != 1 or homes[0].first is None or homes[0].last is None:
        return None
    return homes[0].first, homes[0].last


def _is_positioned_by_home(commands: Sequence[Command], configurations: Sequence[Configuration]) -> bool:
    """Whether an axis gets its position only from a search for the home switch, not for a marker."""
    kinds = {command.kind for command in commands if command.kind in ("home", "set_position")}
    uses_marker = any(configuration.marker_home for configuration in configurations)
    return kinds == {"home"} and bool(configurations) and not uses_marker


def _beyond_limit(
    subject: Subject, slot: SlotSpec, move: Command, home: tuple[float, float]
) -> Iterator[Violation]:
    """Find the first position of an absolute move that is beyond a limit switch."""
    configurations = subject.configurations(slot.number)
    first, last = home
    for position in _possible(move, "position"):
        if not position.is_constant:
            continue
        limit = _limit_before(slot.machine, position.least + first, position.most + last)
        if limit is not None and all(configuration.inputs_used & limit for configuration in configurations):
            yield Violation(
                move.place, f"{move.text} to {position}: the axis reaches {input_name(limit)} first"
            )
            return


def _limit_before(machine: MachineSpec, low: float, high: float) -> InputBit | None:
    """Return the limit switch between shaft position 0 and the range `low` to `high`; None without one."""
    for switch in machine.switches:
        if switch.input == InputBit.CW_LIMIT and switch.first is not None and low > switch.first > 0:
            return switch.input
        if switch.input == InputBit.CCW_LIMIT and switch.last is not None and high < switch.last < 0:
            return switch.input
    return None


def two_movers(subject: Subject) -> Iterator[Violation]:
    """Find axes that two sequences move without a lock."""
    for commands in subject.by_axis():
        motions = [motion for motion in commands if motion.kind in MOTIONS and motion.owner and motion.axis]
        for motion in motions:
            first = _first_rival(motion, motions)
            if first is not None and first.order < motion.order:
                rival = f"sequence {first.owner} moves in line {first.place.line}"
                text = f"sequence {motion.owner} moves {motion.axis}, which {rival}"
                yield Violation(motion.place, text)
                break


def _first_rival(motion: Command, motions: Sequence[Command]) -> Command | None:
    """Return the first motion of another sequence that shares no lock with this motion."""
    for rival in motions:
        if rival.owner != motion.owner and not rival.locks & motion.locks:
            return rival
    return None


def execute_stays(subject: Subject) -> Iterator[Violation]:
    """Find blocks whose Execute rises once and never falls."""
    for command in subject.facts.commands:
        if command.execute and command.kind not in AT_START and _never_falls(subject, command.execute):
            text = f"{command.text}: its Execute never falls, so the block starts once at most"
            yield Violation(command.place, text)


def _never_falls(subject: Subject, execute: str, depth: int = 8) -> bool:
    """Whether a bit rises at most once. The Done bit of a block stays on as long as its Execute does."""
    if execute == "1":
        return True
    name = next((key for key in subject.facts.variables if _is_part_of(execute, key)), "")
    if not name:
        return False
    if execute == f"{name}.DONE":
        return depth > 0 and _never_falls(subject, _execute_of(subject, name), depth - 1)
    variable = subject.facts.variables[name]
    writes = list(filter(attrgetter("writes"), subject.by_key.get(name, ())))
    if variable.role is not Role.PLAIN or variable.shown:
        return False
    return all(map(_stays_on, writes)) if writes else variable.set


def _execute_of(subject: Subject, block: str) -> str:
    """Return the bit that starts a block; "" if no command uses the block."""
    for command in subject.facts.commands:
        if command.text.upper().endswith(f" {block}"):
            return command.execute
    return ""


def _is_part_of(bit: str, tag: str) -> bool:
    return bit == tag or bit.startswith((f"{tag}.", f"{tag}["))


def _stays_on(write: Access) -> bool:
    return write.use is Touch.LATCH or (write.use is Touch.COIL and write.steady)


def torn(subject: Subject) -> Iterator[Violation]:
    """Find commands that are sent together with their parameters, if an update may arrive in two parts."""
    if subject.job.spec.controller != "compactlogix":
        return
    problem = "a CompactLogix may send the words in two parts, and the command starts with old parameters"
    for place, text in subject.facts.at_once:
        yield Violation(place, f"{text}: {problem}")
