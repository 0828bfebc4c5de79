"""Lowering of the tree for the back ends: resolved addresses, checked operands, numbered instructions."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from scanrack.io_images.site import NOWHERE, Site

from ..instructions.addons import ADD_ON_CALL, ADD_ON_OFF_CALL, OFF
from ..instructions.statements import CONDITION
from ..instructions.stubbed import specs_of_stubs
from ..model.errors import LadderError, Problem
from ..model.operand_checks import OPERAND_CHECKS, WRITTEN, OperandError, is_string, mismatch
from ..model.operands import Constant, Group, Place, Resolved, as_number, constant, first_leaf, leaves_in
from ..model.predefined.words import KEYWORDS, plain
from ..model.resolver import AddressError, Resolver, missing_in
from ..model.routine import Routine
from ..model.spec import InstructionKind, Spec, Use
from ..model.stubs import Stub
from ..model.tags import OWN, FrameLayout, Layout, scoped, tag_in
from ..model.tree import (
    Address,
    Branch,
    Instruction,
    MemberStep,
    Number,
    Operand,
    Origin,
    Rung,
    Series,
    Unknown,
    addresses_in,
    too_deep,
)
from ..model.types import DINT, HIDDEN, LINT, Structure
from ..state.lowered import (
    AddOnCall,
    AddOnFrame,
    LoweredLine,
    LoweredProgram,
    LoweredRoutine,
    LoweredStep,
    Node,
    Parallel,
)
from .addon import LOGIC, OTHERWISE, POSTSCAN, PRESCAN, AddOn, copies_of
from .calls import MODEL, OWNER, inout_arguments, model_number, with_stored_subscripts
from .charts import ChartLowering
from .statements import StatementLowering

_NUMERIC = (Use.NUMBER, Use.INTEGER, Use.EXPRESSION)  # uses that accept characters as numbers: MOV('A',Code)

_KEPT_FLAGS = frozenset({"S:V", "S:Z", "S:N", "S:C"})


class Lowering:
    """Lowers routine by routine into `lowered`, and collects problems and warnings."""

    def __init__(
        self,
        name: str,
        layout: Layout,
        main: str,
        add_ons: Mapping[str, AddOn],
        stubs: Mapping[str, Stub],
        specs: Mapping[str, Spec],
    ) -> None:
        self.lowered = LoweredProgram(name, layout, main.upper())
        self.problems: list[Problem] = []
        self.warnings: list[Problem] = []
        self.lowered.stubs = dict(stubs)
        self._specs = specs
        self._stubbed = specs_of_stubs(stubs)
        self._add_ons = add_ons
        self._pending_add_ons: list[AddOn] = []  # called, but not lowered yet
        self._frame: AddOnFrame | None = None  # the add-on that is being lowered; None for a program
        self._calls_to_check: list[tuple[AddOnCall, Site, str]] = []  # with site and text of the rung
        self.resolver = Resolver(layout)
        self._program = ""
        self._site = NOWHERE
        self._rung_text = ""

    def enter(self, program: str) -> None:
        """Start the routines of a program."""
        self._program = program
        self.resolver = Resolver(self.lowered.layout, program)

    def routine(self, routine: Routine) -> None:
        """Lower a routine after the add-on instructions that it calls."""
        self._lower_routine(replace(routine, name=scoped(self._program, routine.name)))
        resolver, program = self.resolver, self._program
        self._program = ""
        while self._pending_add_ons:
            self._add_on_routines(self._pending_add_ons.pop(0))
        self.resolver, self._program, self._frame = resolver, program, None
        pass_bits_on(self.lowered)
        self._check_handed_inputs()

    def _add_on_routines(self, definition: AddOn) -> None:
        """Lower the routines of an add-on instruction in its frame."""
        self._frame = self.lowered.frames[definition.name.upper()]
        self.resolver = Resolver(self._frame.layout)
        for routine in definition.routines:
            name = routine_name(definition, routine.name)
            self._lower_routine(replace(routine, name=name))
            lowered = self.lowered.routines[name.upper()]
            self.lowered.routines[name.upper()] = replace(lowered, frame=definition.name.upper())

    def _check_handed_inputs(self) -> None:
        """Report calls that pass an input to an InOut that the add-on writes."""
        for call, site, text in self._calls_to_check:
            frame = self.lowered.frames[call.name]
            for name, operand in call.handed.items():
                if is_input(operand) and writes(self.lowered, frame, name):
                    problem = f"{operand.text} is an input, and {frame.name} writes it as {name}"
                    self._note_input(operand, problem, site, text)
        self._calls_to_check.clear()

    def _lower_routine(self, routine: Routine) -> None:
        """Lower a routine of rungs, statements or a chart.

        For rungs, note the labels and the operands of SBR.
        """
        self.begin(routine)
        if routine.chart is not None:
            self._lower_chart(routine)
            return
        if routine.statements is not None:
            lowered = StatementLowering(self).routine(routine.name, routine.statements)
            self.lowered.routines[routine.name.upper()] = lowered
            return
        lines = []
        labels: dict[str, int] = {}
        parameters: tuple[Place, ...] | None = None
        for number, rung in enumerate(routine.rungs):
            line = self.line(number, rung)
            lines.append(line)
            for step in line.all_steps:
                if step.name == "LBL" and step.operands:
                    self._label(labels, step.operands[0], number, first=line.nodes[0] is step)
                elif step.name == "SBR" and number == 0 and line.nodes[0] is step:
                    parameters = step.operands
                elif step.name == "SBR":
                    self.report("SBR is not first", "make it the first of the routine's first rung")
        self.lowered.routines[routine.name.upper()] = LoweredRoutine(
            routine.name, tuple(lines), labels, parameters
        )

    def _lower_chart(self, routine: Routine) -> None:
        """Lower a chart, and the bodies of its actions as their own routines."""
        chart = ChartLowering(self, routine)
        self.lowered.routines[routine.name.upper()] = chart.routine()
        for name, block in chart.bodies():
            self._lower_routine(Routine(name, (), statements=block))

    def begin(self, routine: Routine) -> None:
        """Start a routine under its full name."""
        self._site = Site(self._program or self.lowered.name, routine.name, unit=routine.unit)

    def report(self, text: str, remedy: str, instruction: str = "", tag: str = "") -> None:
        """Add a problem with the current rung, with an instruction in it, or with a missing tag."""
        site = replace(self._site, instruction=instruction, tag=tag)
        self.problems.append(Problem(site.where, self._rung_text, text, remedy, site))

    def _label(self, labels: dict[str, int], label: str, number: int, *, first: bool) -> None:
        """Note the rung of a label; report a duplicate, or a label that is not first in its rung."""
        if label in labels:
            self.report(f"label {label} is in the routine twice", "rename one")
        if not first:
            self.report(f"LBL({label}) is not first in its rung", "put it first", f"LBL({label})")
        labels[label] = number

    def at(self, number: int, origin: Origin, text: str) -> None:
        """Start a rung or a line of structured text."""
        site = self._site  # `replace` takes three times as long
        self._site = Site(
            site.program, site.routine, number, unit=site.unit, file=origin.file, line=origin.line
        )
        self._rung_text = text

    def line(self, number: int, rung: Rung) -> LoweredLine:
        """Lower a rung of the current routine.

        Report a rung that is nested too deeply or has no output, and an MCR that is not last.
        """
        deep = too_deep(rung.series)
        self.at(number, rung.origin, "" if deep else str(rung))
        if deep:
            self.report(deep, "split the rung with an internal bit")
            return LoweredLine(number, (), rung.origin, "", rung.comment)
        nodes = self._series(rung.series)
        line = LoweredLine(number, nodes, rung.origin, self._rung_text, rung.comment)
        steps = line.all_steps
        if steps and all(step.kind is InstructionKind.INPUT and not step.spec.alone for step in steps):
            self.report("the rung has no output", "end it with a coil or another output instruction")
        for step in steps:
            if step.name == "MCR" and nodes[-1] is not step:
                self.report("MCR is not last in its rung", "move the instructions after it to another rung")
        return line

    def _series(self, series: Series) -> tuple[Node, ...]:
        """Lower a series; a branch becomes a `Parallel`."""
        return tuple(
            Parallel(tuple(map(self._series, element.legs)))
            if isinstance(element, Branch)
            else self.step(element)
            for element in series
        )

    def site(self, text: str) -> int:
        """Add an instruction of the current rung or line to the sites; return its number."""
        site = self._site
        self.lowered.sites.append(
            Site(site.program, site.routine, site.rung, text, unit=site.unit, file=site.file, line=site.line)
        )
        return len(self.lowered.sites) - 1

    def step(self, instruction: Instruction) -> LoweredStep:
        """Lower an instruction, and report wrong operands.

        A stub has precedence over an add-on instruction, which has precedence over a built-in instruction.
        """
        name = instruction.name.upper()
        stub = self._stubbed.get(name)
        definition = None if stub else self._add_ons.get(name.removesuffix(OFF.upper()))
        spec = stub or (definition.spec if definition else self._specs.get(instruction.name, CONDITION))
        site = self.site(str(instruction))
        if definition:
            call = ADD_ON_CALL if name == definition.name.upper() else ADD_ON_OFF_CALL
            return LoweredStep(call, self._add_on_call(definition, instruction), site)
        try:
            operands = self._operands(spec, instruction)
        except (AddressError, OperandError) as error:
            self.report(f"{instruction}: {error}", error.remedy, str(instruction), missing_in(error))
            operands = ()
        if spec.name == "MCR":
            self.lowered.override = True
        if not spec.in_rungs and self._site.unit == "rung":
            self.report(
                f"{spec.name} is an instruction of structured text", "use a timer or counter of rungs"
            )
        return LoweredStep(spec, operands, site)

    def _add_on_call(self, definition: AddOn, call: Instruction) -> tuple[AddOnCall, ...]:
        """Return the single operand of an add-on's call; report wrong arguments and return ()."""
        try:
            instance = self._instance(definition, call)
            frame = self._frame_of(definition)
            address, storing_rungs = with_stored_subscripts(self.resolver, call.operands[0])
            copies = copies_of(definition, address, call)
            handed = inout_arguments(definition, copies.handed, self.resolver)
        except (AddressError, OperandError) as error:
            self.report(f"{call}: {error}", error.remedy, str(call), missing_in(error))
            return ()
        except LadderError as error:
            remedy = f"operands of {definition.name} are {_signature(definition)}"
            self.report(f"{call}: {error}", remedy, str(call))
            return ()
        if storing_rungs:
            instance = self._instance(definition, replace(call, operands=(address, *call.operands[1:])))
        self._note_handed(frame, instance, handed)
        if definition.name.upper() == OWNER:
            self._note_model(definition, instance, handed["OUTPUTS"], call)
        names = {
            routine.name: routine_name(definition, routine.name).upper() for routine in definition.routines
        }
        lowered = AddOnCall(
            definition.name.upper(),
            replace(instance, text=str(call.operands[0])),
            handed,
            enable_in=instance.member("EnableIn"),
            enable_out=instance.member("EnableOut"),
            inputs=tuple(map(self._series, (*storing_rungs, *copies.inputs))),
            outputs=tuple(map(self._series, copies.outputs)),
            logic=names[LOGIC],
            otherwise=names.get(OTHERWISE),
            prescan=names.get(PRESCAN),
            postscan=names.get(POSTSCAN),
        )
        if self._frame is not None:
            self._frame.calls.append(lowered)
        self._calls_to_check.append((lowered, self._site, str(call)))
        return (lowered,)

    def _note_model(
        self, definition: AddOn, instance: Group, outputs: Place | Group, call: Instruction
    ) -> None:
        """Set a networked drive's model in the instance that owns its words; report blocks with no model."""
        number = model_number(self.lowered.layout.modules.get(first_leaf(outputs).slot or 0))
        if any(parameter.name == MODEL for parameter in definition.parameters):
            index = instance.member(MODEL).fixed_index
            if number and index is not None:
                self.lowered.presets[instance.member(MODEL).leaf.path, index] = number
        elif number:
            text = f"{call}: the module is a networked drive, but these blocks are for the 3601 only"
            self.report(text, 'use load_library("axis3601", drives=True)', str(call))

    def _frame_of(self, definition: AddOn) -> AddOnFrame:
        """Return the frame of an add-on instruction and queue its routines for lowering."""
        name = definition.name.upper()
        if name not in self.lowered.frames:
            layout = FrameLayout(name, definition.structure, definition.inouts, self.lowered.layout)
            self.lowered.frames[name] = AddOnFrame(definition.name, layout)
            self._pending_add_ons.append(definition)
        return self.lowered.frames[name]

    def _note_handed(self, frame: AddOnFrame, instance: Group, handed: Mapping[str, Place | Group]) -> None:
        """Lay out the arguments of a call in lists, and note InOuts that receive bits."""
        for operand in (instance, *handed.values()):
            leaf = first_leaf(operand)
            if not leaf.frame:
                self.lowered.layout.box(leaf)
        frame.bits.update(
            name for name, operand in handed.items() if isinstance(operand, Place) and operand.bit is not None
        )

    def _instance(self, definition: AddOn, call: Instruction) -> Group:
        """Return the instance of a call; raise an OperandError if it is not an instance of the add-on."""
        instance = self.resolver.operand(call.operands[0])
        if not isinstance(instance, Group) or instance.dims or instance.type != definition.structure:
            remedy = f"declare a tag of type {definition.name} for this call"
            raise mismatch(call.operands[0], instance, f"an instance of {definition.name}", remedy)
        return instance

    def _operands(self, spec: Spec, instruction: Instruction) -> tuple[Any, ...]:
        """Resolve and check the operands of an instruction, and note its presets."""
        arguments = instruction.operands
        if spec.resolve is not None:
            return spec.resolve(self, arguments)
        pairs = zip(spec.operands, arguments, strict=False)  # optional operands may be missing
        operands = [self.checked(use, operand) for use, operand in pairs if use is not Use.PRESET]
        if Use.TEXT_OR_NUMBER in spec.operands and not all(map(is_string, operands)):
            operands = list(map(as_number, operands))  # strings are compared with and moved to strings only
        self._note_presets(spec, arguments, operands)
        if spec.check is not None:
            spec.check(*operands)
        return tuple(operands)

    def checked(self, use: Use, operand: Operand) -> Any:
        """See `OperandResolver`."""
        if use in (Use.LABEL, Use.MODE):
            if not isinstance(operand, Address) or operand.steps:
                raise OperandError(f"{operand} is not a name", "write a name")
            return operand.name.upper()
        if use is Use.PASSES:
            return _passes(operand)
        if use in (Use.IGNORED, Use.SHOWN) and isinstance(operand, Unknown):
            return constant(0)
        if use is Use.KEYWORD and (word := self._keyword(operand)):
            return word
        resolved = self.resolver.operand(operand)
        self.note_flags(operand)
        if use in _NUMERIC:
            resolved = as_number(resolved)
        _check(use, operand, resolved)
        if use in WRITTEN and isinstance(resolved, (Place, Group)):
            self.note_written(operand, resolved)
        return resolved

    def _keyword(self, operand: Operand) -> str:
        """Return a keyword in its structured text form, in capitals; "" for another operand.

        Raise an OperandError for a name that is neither a tag nor a keyword.
        """
        if not isinstance(operand, Address) or operand.steps:
            return ""
        word = plain(operand.name)
        if self.lowered.layout.declaration(operand.name.upper(), self._program) is not None:
            number = OPERAND_CHECKS[Use.NUMBER].accepts(self.resolver.address(operand))
            return "" if number or word not in KEYWORDS else word
        if word not in KEYWORDS:
            close = difflib.get_close_matches(word, KEYWORDS, n=1)
            hint = f"did you mean {close[0]}" if close else "name a tag, a number or a word of its list"
            raise OperandError(f"{operand} is neither a tag nor a word of a list", hint)
        return word

    def note_written(self, operand: Operand, resolved: Place | Group) -> None:
        """Note that an operand is written, if it is an add-on's InOut or a module's input."""
        if self._frame is not None:
            self._frame.written.add(first_leaf(resolved).root)
        elif is_input(resolved):
            self._note_input(resolved, f"{operand} is an input", self._site, self._rung_text)

    def _note_input(self, resolved: Place | Group, text: str, site: Site, rung: str) -> None:
        """Warn that an input is written; it keeps the value only until the module's next update."""
        self.lowered.written_inputs.update(leaf.ident for leaf in leaves_in(resolved))
        remedy = "write a tag of your own"
        text = f"{text}: its module writes over it"
        self.warnings.append(Problem(site.where, rung, text, remedy, site, "input-written"))

    def note_flags(self, operand: Operand) -> None:
        """Enable the status flags if an operand is a status flag."""
        if any(address.name.upper() in _KEPT_FLAGS for address in addresses_in(operand)):
            self.lowered.flags = True

    def _note_presets(self, spec: Spec, arguments: tuple[Operand, ...], operands: list[Any]) -> None:
        """Note the initial values of timers, counters and controls in a rung.

        Args:
            operands: the resolved operands, without the presets.
        """
        if Use.PRESET not in spec.operands:
            return
        indices = (index for index, use in enumerate(spec.operands) if use is not Use.PRESET)
        resolved = dict(zip(indices, operands, strict=False))  # optional operands may be missing
        for index, (structure, name) in spec.members.items():
            if index < len(arguments):
                self._note_initial(resolved[structure], name, arguments[index])

    def _note_initial(self, structure: Group, name: str, operand: Operand) -> None:
        """Note a preset in a rung as an initial value.

        Raise an OperandError for an invalid number, or a number that differs from the preset in another rung.
        """
        if isinstance(operand, Unknown):
            return
        place = structure.member(name)
        real = place.type.is_real
        if not isinstance(operand, Number) or not (real or isinstance(operand.value, int)):
            raise OperandError(
                f"{name} {operand} is not a whole number", f"write a number, or MOV to .{name}"
            )
        if not real and not DINT.lowest <= operand.value <= DINT.highest:
            raise OperandError(f"{name} {operand} is not a DINT", f"write a number up to {DINT.highest:,}")
        index = place.fixed_index
        if index is None:
            raise OperandError(
                f"{name} is not allowed in the rung because of the computed index", "write ? and MOV to it"
            )
        presets = self.lowered.presets
        if self._frame is not None:
            if place.leaf.root != OWN:
                raise OperandError(f"{name} of an InOut has a value in the rung", "write ? and MOV to it")
            presets = self._frame.presets
        value = float(operand.value) if real else operand.value
        earlier = presets.setdefault((place.leaf.path, index), value)
        if earlier != value:
            name_text = place.leaf.path if place.leaf.size == 1 else place.text
            raise OperandError(f"{name_text} is {earlier} in another rung", "write the same number, or ?")

    def named(self, routine: str) -> str:
        """See `OperandResolver`."""
        return scoped(self._program, routine).upper()

    def memory(self, address: Address, *, written: bool) -> Place | Group:
        """See `OperandResolver`.

        The first member of a structure represents the structure, as in exports.
        """
        resolved = self.resolver.address(address)
        if isinstance(resolved, Place) and address.steps and isinstance(address.steps[-1], MemberStep):
            structure = self.resolver.address(replace(address, steps=address.steps[:-1]))
            if (
                isinstance(structure, Group)
                and isinstance(structure.type, Structure)
                and structure.type.members[0].name.upper() == address.steps[-1].name.upper()
            ):
                resolved = structure
        _check(Use.DESTINATION, address, resolved)
        if written:
            self.note_written(address, resolved)
        return resolved

    def value(self, operand: Operand) -> Resolved:
        """See `OperandResolver`."""
        resolved = self.resolver.operand(operand)
        if not isinstance(resolved, (Place, Constant)):
            raise mismatch(operand, resolved, "one value", "pass its members")
        return resolved

    @property
    def stubs(self) -> Mapping[str, Stub]:
        """See `OperandResolver`."""
        return self.lowered.stubs

    def any_operand(self, operand: Operand) -> Resolved:
        """See `OperandResolver`."""
        return self.resolver.operand(operand)

    def hidden(self, name: str) -> Place:
        """See `OperandResolver`."""
        if self._frame is not None:
            raise OperandError("the instruction is in an add-on instruction", "call it in a program")
        leaf = self.lowered.layout.hidden(f"{HIDDEN}{name}{len(self.lowered.sites)}", LINT)
        return Place(leaf, (), None, leaf.path)

    def kept(self, path: str, initial: int) -> None:
        """See `OperandResolver`."""
        if self.lowered.layout.find(path) is None:
            self.lowered.layout.hidden(path, LINT)
            if initial:
                self.lowered.presets[path, 0] = initial

    def function(self, name: str, function: Callable[..., Any]) -> str:
        """See `OperandResolver`."""
        full = self.named(f"{HIDDEN}{name}")
        self.lowered.functions[full] = function
        return full

    def target(self, operand: Operand) -> Place:
        """See `OperandResolver`."""
        resolved = self.resolver.operand(operand)
        if not isinstance(resolved, Place):
            raise mismatch(operand, resolved, "a tag", "name the tag to write")
        self.note_written(operand, resolved)
        return resolved


def _check(use: Use, operand: Operand, resolved: Resolved) -> None:
    """Raise an OperandError for an operand that a use does not accept."""
    check = OPERAND_CHECKS[use]
    if not check.accepts(resolved):
        raise mismatch(operand, resolved, check.text, check.remedy)


def routine_name(definition: AddOn, role: str) -> str:
    """Return the name of an add-on's routine: its role after a dot."""
    return f"{definition.name}.{role}"


def is_input(operand: Place | Group) -> bool:
    """Return whether a module writes the operand."""
    if isinstance(operand, Group) and tag_in(operand.path).upper() in operand.layout.declarations:
        return False  # a tag has its own memory
    return any(leaf.is_input for leaf in leaves_in(operand))


def pass_bits_on(lowered: LoweredProgram) -> None:
    """Mark InOuts of called add-ons that can be bits because the caller's InOut can be a bit."""
    changed = True
    while changed:
        changed = False
        for frame in lowered.frames.values():
            for call in frame.calls:
                bits = lowered.frames[call.name].bits
                for name, operand in call.handed.items():
                    if operand.frame and first_leaf(operand).root in frame.bits and name not in bits:
                        bits.add(name)
                        changed = True


def writes(lowered: LoweredProgram, frame: AddOnFrame, name: str) -> bool:
    """Return whether an add-on instruction writes an InOut, directly or in a call."""
    if name in frame.written:
        return True
    return any(
        operand.frame
        and first_leaf(operand).root == name
        and writes(lowered, lowered.frames[call.name], inner)
        for call in frame.calls
        for inner, operand in call.handed.items()
    )


def _passes(operand: Operand) -> str:
    """Return a mode of file instructions in capitals: ALL, INC, or the elements per scan."""
    text = str(operand).upper()
    number = operand.value if isinstance(operand, Number) else 0
    if text in ("ALL", "INC") or (isinstance(number, int) and 0 < number <= DINT.highest):
        return text
    raise OperandError(f"{operand} is not a mode", "write ALL, INC, or the number of elements per scan")


def _signature(definition: AddOn) -> str:
    """Return the operands of an add-on's call as text."""
    named = [
        f"{parameter.name} : {parameter.type.name} ({parameter.mode.value})"
        for parameter in definition.required
    ]
    return ", ".join(["the instance", *named])
