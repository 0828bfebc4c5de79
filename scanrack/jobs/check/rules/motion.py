"""Rules about axis commands in any language: what a 3601 refuses in any state.

The limits come from `io_images.amci3601`, and the sentences from its rule table.
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
"""Commands that a program may give only once."""


def out_of_range(subject: Subject) -> Iterator[Violation]:
    """Find arguments that no module accepts, and speeds below the starting speed."""
    for command in subject.facts.commands:
        limits = allowed(command.kind, subject.profile(command.slot).limits)
        wrong = (
            f"{name} is {value}: must be {limits[name][0]} to {limits[name][1]}"
            for name in command.values
            for value in _possible(command, name)
            if name in limits and value.outside(*limits[name])
        )
        text = next(wrong, "") or _no_direction(command) or _too_slow(subject, command)
        if text:
            yield Violation(command.place, f"{command.text}: {text}")


def _no_direction(command: Command) -> str:
    """Return a message about a direction other than 1 and -1; "" if it is one of them, or unknown."""
    way = command.value("direction")
    if way.is_constant and abs(way.least) != 1:
        return f"direction is {way}: must be 1, clockwise, or -1"
    return ""


def _possible(command: Command, name: str) -> list[Range]:
    """Return the values of an argument. Of several, 0 is left out: it is not meant for the command."""
    several = [range_ for range_ in command.choices.get(name, ()) if range_.least or range_.most]
    return several if len(several) > 1 else [command.value(name)]


def _too_slow(subject: Subject, command: Command) -> str:
    least = min(
        (configuration.starting_speed for configuration in subject.configurations(command.slot)), default=0
    )
    speeds = _possible(command, "speed") if command.kind in FROM_STARTING_SPEED else []
    most = subject.profile(command.slot).limits.speed
    for speed in speeds if all(value.most < most for value in speeds) else ():
        if speed.most < least:
            return f"speed {speed} is below the starting speed, {least}"
    return ""


def refused(subject: Subject) -> Iterator[Violation]:
    """Find commands that the module refuses with every configuration of the program."""
    for command in subject.facts.commands:
        configurations = subject.configurations(command.slot)
        rules = [_refusal(command, configuration) for configuration in configurations]
        if rules and all(rules):
            yield Violation(command.place, f"{command.text}: {RULES[rules[0]].text}")


def _refusal(command: Command, configuration: Configuration) -> str:
    """Return the rule of the manual that a command breaks; "" if it breaks none of those checked here."""
    if command.kind == "home":
        way = command.value("direction")
        limit = InputBit.CW_LIMIT if way.least > 0 else InputBit.CCW_LIMIT
        if way.is_constant and not configuration.inputs_used & limit:
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
    """Find axes that move but are not configured before."""
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
        for motion, other in first_before(ordered, motions):
            text = f"{motion.text} comes before the configuration in line {other.place.line}"
            yield Violation(motion.place, text)


def _first_closed(subject: Subject, commands: Sequence[Command], kinds: Collection[str]) -> Command | None:
    """Return the first command of given kinds; None if commands that are not analyzed may reach the axis."""
    first = next((command for command in commands if command.kind in kinds), None)
    return None if first is None or is_open(subject, first) else first


def first_before(needed: Sequence[Command], commands: Sequence[Command]) -> Iterator[tuple[Command, Command]]:
    """Yield the first command that precedes the first one that it needs in their sequence, with that one."""
    if len({command.owner for command in needed}) != 1 or not all(command.order for command in needed):
        return
    first = min(needed, key=lambda each: each.order)
    before = [
        command
        for command in commands
        if command.sure and command.owner == first.owner and 0 < command.order < first.order
    ]
    if before:
        yield min(before, key=lambda each: each.order), first


def _is_sent(subject: Subject, command: Command) -> bool:
    """Whether a module's configuration is sent as words."""
    configurations = subject.facts.configurations
    return command.words and any(sent_command.slot == command.slot for sent_command in configurations)


def is_open(subject: Subject, command: Command) -> bool:
    """Whether commands that are not analyzed may reach the axis."""
    facts = subject.facts
    is_open = facts.reads_all or not command.axis or command.axis in facts.escaped
    return is_open or (command.words and command.slot in facts.computed)


def without_position(subject: Subject) -> Iterator[Violation]:
    """Find absolute moves of axes that never home and whose position is never set."""
    for commands in subject.by_axis():
        first = _first_closed(subject, commands, ("move_to",))
        positioning = [command for command in commands if command.kind in ("home", "set_position")]
        if first is not None and not positioning:
            text = "needs a valid position, and nothing searches for home or sets the position"
            yield Violation(first.place, f"{first.text} {text}")
        moves = [command for command in commands if command.kind == "move_to"]
        for move, other in first_before(positioning, moves) if first is not None else ():
            reason = f"comes before {other.text} in line {other.place.line}: {_section('CMD-06')}"
            text = f"{move.text} needs a valid position, and {reason}: {_section('CMD-06')}"
            yield Violation(move.place, text)


def _section(rule: str) -> str:
    return f"{RULES[rule].text.rstrip('.')} [{RULES[rule].section}]"


def interrupted(subject: Subject) -> Iterator[Violation]:
    """Find motions that begin before the previous one is complete."""
    for commands in subject.by_axis():
        motions = [command for command in commands if command.kind in MOTIONS and command.execute]
        for index, motion in enumerate(motions):
            for other in motions[:index]:
                if _start_together(other, motion):
                    where = f"{other.text} of line {other.place.line}"
                    yield Violation(motion.place, f"{motion.text} aborts {where}: both start in one scan")
        for motion in motions:
            busy = _while_busy(subject, motion, motions)
            if busy is not None:
                text = f"{motion.text} aborts {busy.text} of line {busy.place.line}, which is under way then"
                yield Violation(motion.place, text)


def _start_together(one: Command, other: Command) -> bool:
    """Whether the same bit, or the same condition of bits and steps, starts two blocks."""
    return one.execute == other.execute != "1" or bool(other.starts and one.starts == other.starts)


def _while_busy(subject: Subject, command: Command, motions: Sequence[Command]) -> Command | None:
    """Return the motion whose Busy or Active bit starts a command; None if there is none."""
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

    Position 0 is where the home search ends, which is at one end of the home switch's range.
    """
    for _, slot in subject.steppers:
        own = [command for command in subject.facts.commands if command.slot == slot.number]
        home = _home_range(slot.machine)
        if home is None or not _is_positioned_by_home(own, subject.configurations(slot.number)):
            continue
        for move in own:
            if move.kind == "move_to":
                yield from _beyond_limit(subject, slot, move, home)


def _home_range(machine: MachineSpec) -> tuple[float, float] | None:
    """Return the ends of a home switch; None if there is none or several, or if its range is open."""
    homes = [switch for switch in machine.switches if switch.input == InputBit.HOME]
    if len(homes) != 1 or homes[0].first is None or homes[0].last is None:
        return None
    return homes[0].first, homes[0].last


def _is_positioned_by_home(commands: Sequence[Command], configurations: Sequence[Configuration]) -> bool:
    """Whether an axis gets its position only from a search for the home switch, not for a marker."""
    kinds = {command.kind for command in commands if command.kind in ("home", "set_position")}
    is_by_switch = bool(configurations) and not any(
        configuration.marker_home for configuration in configurations
    )
    return kinds == {"home"} and is_by_switch


def _beyond_limit(
    subject: Subject, slot: SlotSpec, move: Command, home: tuple[float, float]
) -> Iterator[Violation]:
    """Find the first position of an absolute move that lies beyond a limit switch."""
    configurations = subject.configurations(slot.number)
    for position in filter(lambda each: each.is_constant, _possible(move, "position")):
        limit = _limit_at(slot.machine, position.least + home[0], position.most + home[1])
        if limit is not None and all(configuration.inputs_used & limit for configuration in configurations):
            yield Violation(move.place, f"{move.text} to {position}: {input_name(limit)} is operated before")
            return


def _limit_at(machine: MachineSpec, low: float, high: float) -> InputBit | None:
    """Return the limit switch beyond which a whole range of the shaft lies; None if there is none."""
    for switch in machine.switches:
        if switch.input == InputBit.CW_LIMIT and switch.first is not None and low > switch.first > 0:
            return switch.input
        if switch.input == InputBit.CCW_LIMIT and switch.last is not None and high < switch.last < 0:
            return switch.input
    return None


def two_movers(subject: Subject) -> Iterator[Violation]:
    """Find axes that two sequences move without a lock."""
    for commands in subject.by_axis():
        moving = [mover for mover in commands if mover.kind in MOTIONS and mover.owner and mover.axis]
        firsts = ((mover, _other_mover(mover, moving)) for mover in moving)
        for command, first in firsts:
            if first is not None and first.order < command.order:
                where = f"sequence {first.owner} moves in line {first.place.line}"
                text = f"sequence {command.owner} moves {command.axis}, which {where}"
                yield Violation(command.place, text)
                break


def _other_mover(command: Command, moving: Sequence[Command]) -> Command | None:
    """Return the first motion of another sequence that shares no lock with this one."""
    others = (rival for rival in moving if rival.owner != command.owner and not rival.locks & command.locks)
    return next(others, None)


def execute_stays(subject: Subject) -> Iterator[Violation]:
    """Find blocks whose Execute rises once and never falls."""
    for command in subject.facts.commands:
        if command.execute and command.kind not in AT_START and _never_falls(subject, command.execute):
            yield Violation(
                command.place, f"{command.text}: its Execute never falls, so the block starts once at most"
            )


def _never_falls(subject: Subject, execute: str, depth: int = 8) -> bool:
    """Whether a bit rises at most once. Done of a block stays on as long as its Execute."""
    if execute == "1":
        return True
    name = next((key for key in subject.facts.variables if _is_part_of(execute, key)), "")
    if not name:
        return False
    if execute == f"{name}.DONE":
        return depth > 0 and _never_falls(subject, _execute_of(subject, name), depth - 1)
    variable = subject.facts.variables[name]
    writes = list(filter(attrgetter("writes"), subject.by_key.get(name, ())))
    is_own = variable.role is Role.PLAIN and not variable.shown
    return is_own and (all(map(_stays_on, writes)) if writes else variable.set)


def _execute_of(subject: Subject, block: str) -> str:
    """Return the bit that starts a block; "" if no command has that block."""
    own = (
        command.execute for command in subject.facts.commands if command.text.upper().endswith(f" {block}")
    )
    return next(own, "")


def _is_part_of(bit: str, tag: str) -> bool:
    return bit == tag or bit.startswith((f"{tag}.", f"{tag}["))


def _stays_on(write: Access) -> bool:
    return write.use is Touch.LATCH or (write.use is Touch.COIL and write.steady)


def torn(subject: Subject) -> Iterator[Violation]:
    """Find commands that are sent together with their parameters, if an update may arrive in two parts."""
    if subject.job.spec.controller != "compactlogix":
        return
    for place, text in subject.facts.at_once:
        yield Violation(
            place, f"{text}: a CompactLogix may send the words in two parts, and half a command starts"
        )
