"""Reads and writes programs as vendor-neutral text: `.rung` files with tags and routines.

    PROGRAM line
    DIALECT slc                                   // instructions of an SLC 500, see docs/slc.md
    USE axis3601                                  // add-on instructions of scanrack
    TYPE Step (Time : DINT, Valve : BOOL)
    TYPE Flags (Host : SINT HIDDEN, Ready : BOOL AT Host.0)   // Ready is the name of a bit
    TAG Run : BOOL
    TAG Recipe : Step[10] := [{"Time": 100}]      // initial values are JSON, 16#FF is allowed
    SLOT axis : 1
    ALIAS Go : Local:1:I.Data[1].2
    ALIAS Drive:I : Local:1:I AS Inputs           // names of a declared TYPE for a module's image
    STUB MSG : done after 20 ms                   // the result of every message, see `stubs`
    ROUTINE Main
    // a comment on the rung below
    [XIC(Go),XIC(Run)]XIO(axis.status.INPUT_ERROR)OTE(Run);
    END

A controller has tags, tasks and programs, see `controller` and `schedule`:

    CONTROLLER plant
    TAG Run : BOOL                                // a tag that all programs share
    TASK Cycle : CONTINUOUS RUNS Main
    TASK Fast : PERIODIC 10 ms PRIORITY 3 PREEMPT RUNS Filter, Regulator
    TASK Alarm : EVENT PRIORITY 2 RUNS Bell       // when EVENT(Alarm) triggers it
    PROGRAM Main MAIN Start FAULT Trouble
    TAG Count : DINT                              // a tag that only this program has
    ROUTINE Start
    ...
    END
    END PROGRAM

`ROUTINE Fill SFC` is a sequential function chart, see `chartreader`. A CHARTS line below the head sets the
options for all charts: CURRENT or UNTIL_FALSE (execution control), MOST_RECENT or INITIAL (restart position),
DONT_SCAN, PROGRAMMATIC or AUTOMATIC (last scan of active steps). The first of each is the default.

Add-on instructions come before the tags that are instances of them, see `addon`. The first routine is the
main routine unless PROGRAM has `MAIN name`. A rung ends with a semicolon and can span several lines; `//`
starts a comment. `ROUTINE Fill ST` is a structured text routine that ends with the line END.

A `.st` file can begin with the lines that precede the first ROUTINE, followed by statements.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.site import Site
from scanrack.io_images.text_limits import TextKind, TextLimitError, check_text
from scanrack.io_images.times import time_text

from ..lowering.addon import AddOn
from ..lowering.controller import Controller
from ..lowering.dialects import LOGIX
from ..lowering.program import Program
from ..lowering.runnable import LadderLogic, declared
from ..model.chart import DEFAULT_OPTIONS
from ..model.errors import LadderError
from ..model.predefined.structures import PREDEFINED_TYPES
from ..model.routine import Routine
from ..model.schedule import Task
from ..model.statements import block_lines
from ..model.stubs import NO_STUBS, Ending, InPython, Partner, Stubs
from ..model.tags import Alias, SlotAlias, Tag
from ..model.types import DataType, Elementary, Member, dims_text
from .rungreader import LIBRARIES, Reader, is_of_library, load_library
from .suffixes import STRUCTURED_SUFFIX, SUFFIX


def read_program(path: Path | str) -> Program | Controller:
    """Read a program from a file.

    Raises:
        RungTextError: the text has a syntax error; the message names file, rung, line and column.
        LadderError: a declaration is not allowed.
        OSError: the file can't be read.
    """
    file = Path(path)
    if file.suffix == STRUCTURED_SUFFIX:
        return parse_structured(read_input_text(file, TextKind.STRUCTURED), file.stem, file=str(file))
    return parse_program(read_input_text(file, TextKind.RUNGS), file=str(file))


def parse_program(text: str, *, file: str = "", stubs: Stubs = NO_STUBS) -> Program | Controller:
    """Read a program or a controller from text, see `read_program`; `stubs` override the text's stubs."""
    _check(text, TextKind.RUNGS, file)
    return Reader(text, file, stubs).program()


def parse_structured(text: str, name: str, *, file: str = "", stubs: Stubs = NO_STUBS) -> Program:
    """Read declarations and structured text, see `parse_program`; `name` is the default program name."""
    _check(text, TextKind.STRUCTURED, file)
    return Reader(text, file, stubs).structured(name)


def _check(text: str, kind: TextKind, file: str) -> None:
    """Raise a LadderError if a text exceeds the limits of its language."""
    try:
        check_text(text, kind)
    except TextLimitError as error:
        raise LadderError.at(Site(file=file, line=error.line), str(error)) from None


def write_program(program: Program | Controller, path: Path | str) -> None:
    """Write a program to a file; raise a LadderError if it has no text form, as with Python routines."""
    is_structured = Path(path).suffix == STRUCTURED_SUFFIX
    text = structured_text(program) if is_structured else program_text(program)
    Path(path).write_text(text, encoding="utf-8", newline="\n")


def structured_text(program: Program | Controller) -> str:
    """Return the text of a `.st` file.

    Raises:
        LadderError: the program is not a single structured text routine.
    """
    statements = [routine.statements for routine in program.routines]
    is_single_routine = isinstance(program, Program) and not (
        program.functions or program.allowed or program.fault
    )
    if not is_single_routine or len(statements) != 1 or statements[0] is None:
        raise LadderError(
            f"{program.kind} {program.name} is not one routine of structured text; "
            f"write it to a {SUFFIX} file"
        )
    lines = [f"PROGRAM {program.name}", "", *_declared(program), "", *block_lines(statements[0])]
    return "\n".join(lines) + "\n"


def program_text(program: Program | Controller) -> str:
    """Return a program or controller as text; raise a LadderError if it has Python routines."""
    if program.functions:
        names = ", ".join(program.functions)
        raise LadderError(
            f"{program.kind} {program.name} has routines in Python ({names}), which have no rung text"
        )
    if isinstance(program, Controller):
        head, body = f"CONTROLLER {program.name}", _tasks_and_programs(program)
    else:
        head, body = _head(program), _routines(program)
    return "\n".join([head, *_options(program), "", *_declared(program), *body]) + "\n"


def _tasks_and_programs(controller: Controller) -> Iterator[str]:
    """Yield the lines of a controller's tasks, then the lines of its programs."""
    yield from map(_task_text, controller.tasks)
    for program in controller.programs:
        yield from ("", _head(program), *_declarations(program), *_routines(program), "END PROGRAM")


def _task_text(task: Task) -> str:
    """Return the line that declares a task."""
    words = [f"TASK {task.name} : {task.kind.value}"]
    if task.rate_ns:
        words.append(time_text(task.rate_ns))
    words.append(f"PRIORITY {task.priority}")
    if task.preempt:
        words.append("PREEMPT")
    if task.programs:
        words.append(f"RUNS {', '.join(task.programs)}")
    if task.comment:
        words.append(f" // {task.comment}")
    return " ".join(words)


def _head(program: Program) -> str:
    """Return the line that begins a program, with its main and fault routines if they are set."""
    roots = [f" {word} {name}" for word, name in (("MAIN", program.main), ("FAULT", program.fault)) if name]
    return f"PROGRAM {program.name}{''.join(roots)}"


def _options(logic: LadderLogic) -> Iterator[str]:
    """Yield the lines for the dialect, allowed warnings and chart options that are not defaults."""
    if logic.dialect != LOGIX:
        yield f"DIALECT {logic.dialect}"
    yield from (f"ALLOW {name}" for name in sorted(logic.allowed))
    options = logic.chart_options
    if options != DEFAULT_OPTIONS:
        yield f"CHARTS {options.control.value} {options.restart.value} {options.last_scan.value}"


def _declared(logic: LadderLogic) -> Iterator[str]:
    """Yield the lines of types, tags and stubs."""
    yield from (*_types(logic), *_declarations(logic), *_stubs(logic))


def _routines(program: Program) -> Iterator[str]:
    for routine in program.routines:
        yield from ("", *_routine_text(routine))


def _routine_text(routine: Routine) -> Iterator[str]:
    """Yield the lines of a routine, from its head to END."""
    if routine.chart is not None:
        kind, lines = " SFC", iter(routine.chart.lines())
    elif routine.statements is not None:
        kind, lines = " ST", iter(block_lines(routine.statements))
    else:
        kind, lines = "", _rung_lines(routine)
    yield from (f"ROUTINE {routine.name}{kind}", *lines, "END")


def _rung_lines(routine: Routine) -> Iterator[str]:
    for rung in routine.rungs:
        yield from (f"// {line}" for line in rung.comment.splitlines())
        yield str(rung)


def instruction_text(definition: AddOn) -> str:
    """Return an add-on instruction as text."""
    lines = [f"INSTRUCTION {definition.name}{_comment_text(definition.comment)}"]
    for parameter in definition.parameters:
        required = " REQUIRED" if parameter.required else ""
        kind = f"{parameter.type.name}{dims_text(parameter.dims)}"
        overlay = f" AT {parameter.at}" if parameter.at else ""
        attributes = (
            f"{required}{overlay}{_initial_text(parameter.initial)}{_comment_text(parameter.comment)}"
        )
        lines.append(f"{parameter.mode.value} {parameter.name} : {kind}{attributes}")
    for routine in definition.routines:
        lines += _routine_text(routine)
    return "\n".join([*lines, "END INSTRUCTION"]) + "\n"


def _types(logic: LadderLogic) -> Iterator[str]:
    """Yield the lines of structures and add-on instructions, each after the types that it uses."""
    written: dict[str, DataType] = dict(PREDEFINED_TYPES)
    for name in LIBRARIES:
        if any(is_of_library(add_on, name) for add_on in logic.add_ons.values()):
            written.update(load_library(name).types)
            yield f"USE {name}"
    programs = logic.programs if isinstance(logic, Controller) else []
    for scope in (logic, *programs):
        for declaration in scope.declarations:
            if isinstance(declaration, Tag | Alias) and declaration.type:
                yield from _type_lines(declaration.type, logic.add_ons, written)


def _type_lines(kind: DataType, add_ons: Mapping[str, AddOn], written: dict[str, DataType]) -> Iterator[str]:
    """Yield the lines of the types that a type uses, then its own; skip types that are `written`."""
    if isinstance(kind, Elementary) or kind.name in written:
        return
    definition = add_ons.get(kind.name.upper())
    for member in kind.members:
        yield from _type_lines(member.type, add_ons, written)
    for parameter in definition.parameters if definition else ():
        yield from _type_lines(parameter.type, add_ons, written)
    written[kind.name] = kind
    if definition:
        yield instruction_text(definition).rstrip()
    else:
        yield f"TYPE {kind.name} ({', '.join(_member_text(member) for member in kind.members)})"


def _member_text(member: Member) -> str:
    overlay = f" AT {member.at}" if member.at else ""
    hidden = " HIDDEN" if member.hidden else ""
    return f"{member.name} : {member.type.name}{dims_text(member.dims)}{overlay}{hidden}"


def _initial_text(initial: object) -> str:
    return "" if initial is None else f" := {json.dumps(initial)}"


def _comment_text(comment: str) -> str:
    return f"  // {comment}" if comment else ""


def _declarations(logic: LadderLogic) -> Iterator[str]:
    """Yield the lines of tags, slots and aliases."""
    for declaration in logic.declarations:
        if isinstance(declaration, Tag):
            text = f"TAG {declared(declaration)}{_initial_text(declaration.initial)}"
        elif isinstance(declaration, SlotAlias):
            text = f"SLOT {declaration.name} : {declaration.slot}"
        else:
            bound = f" AS {declaration.type.name}" if declaration.type else ""
            text = f"ALIAS {declaration.name} : {declaration.target}{bound}"
        yield text + _comment_text(declaration.comment)


def _stubs(logic: LadderLogic) -> Iterator[str]:
    """Yield the lines of stubs without their replies; raise a LadderError for a stub in Python."""
    for name, stub in logic.stubs.items():
        if isinstance(stub, Partner):
            continue  # it is configured in a rack file
        if isinstance(stub, Ending):
            stub = replace(stub, reply=None)
        if isinstance(stub, InPython):
            raise LadderError(f"the stub of {name} is in Python; write it in a rack file, not in rung text")
        yield f"STUB {name} : {stub}"
