"""Facts of a program with sequences, from its class declarations and its text.

    axis = Axis3601(1, Configuration(...))        the configuration of slot 1
    start = Input("Local:2:I.Data.0")             a terminal, which the rack may lack
    await self.axis.move_to(9_000_000, ...)       a command with constants; unknown values count as legal
    while True: self.count += 1                   a loop that never waits

No sequence runs. The class is attached to images without any modules.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatch
from inspect import getattr_static
from pathlib import Path
from typing import Any

from scanrack.io_images.amci3601 import Configuration
from scanrack.io_images.annotations import declared
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.site import NOWHERE, SiteError, sites_of
from scanrack.io_images.text_limits import TextKind
from scanrack.ladder.python.axis3601 import Axis3601
from scanrack.ladder.python.sequences import (
    Input,
    InputWord,
    Lock,
    Logic,
    Output,
    OutputWord,
    fresh,
    parts_of,
    sequences_of,
)
from scanrack.ladder.python.sequences.blocks import Block, Timer
from scanrack.ladder.python.sequences.logic import fields_of
from scanrack.ladder.python.sequences.parts import DeclarationError
from scanrack.ladder.python.sequences.signals import Signal
from scanrack.runtime.config.rackspec import RackSpec

from ...load.bare_slots import bare_slots
from ..facts import Facts, FileLine, Role, SentCommand, UsesBit, Variable, Violation
from ..written import place_at
from .attributes import note_names
from .calls import Calls
from .counting import never_called, note_counting
from .flow import Flow
from .images import Images
from .loops import endless, fixed_loops, skips_wait
from .names import Accesses, called_twice, variables_of
from .nodes import Function, assignments_in, field_of, is_loaded, is_stored, nodes_in, stored_attributes
from .numbers import Numbers
from .reader import Reader, functions_in
from .reals import note_reals
from .scans import word_loss
from .sequence_summaries import Method, SequenceSummaries
from .steps import PythonSteps
from .times import note_short_times
from .walk import Walk


def sequence_facts(path: Path, program: Logic, spec: RackSpec) -> Facts:
    """Return the facts of a program with sequences, from an instance of its class."""
    facts = Facts(not_seen=["values that the program computes"])
    _SequenceReader(path, fresh(program), spec, facts).note()
    return facts


def _note_axis(axis: Axis3601, path: Path, facts: Facts) -> None:
    """Note the configuration of an axis, and an axis that sends commands together with their parameters."""
    place = place_at(axis.declared, path)
    if isinstance(axis.configuration, Configuration):  # the rules read only the words of a 3601
        words = tuple(axis.configuration.to_image().words.tolist())
        facts.configurations.append(SentCommand(place, axis.slot, words))
    if not axis.parameters_first:
        text = f"{axis.name} sends each command together with its parameters"
        facts.at_once.append(Violation(place, text))


class _SequenceReader:
    """Reads how the methods of a class use its fields, terminals, axes and locks."""

    def __init__(self, path: Path, logic: Logic, spec: RackSpec, facts: Facts) -> None:
        """Read the texts of the class and its bases, and sort the parts of the instance by kind."""
        self._path, self._logic, self._spec, self._facts = path, logic, spec, facts
        texts = list(_texts(type(logic), path))
        self._trees = [tree for _, tree, _ in texts]
        fields = _constant_fields(logic, self._trees)
        self._readers = [Reader(str(file), tree, names, facts, fields) for file, tree, names in texts]
        self._attributes = {node.attr for node in nodes_in(self._trees, ast.Attribute)}
        self._constants = {node.value for node in nodes_in(self._trees, ast.Constant)}
        self._parts = {part.name: part for part in parts_of(logic)}
        self._axes = {name: part for name, part in self._parts.items() if isinstance(part, Axis3601)}
        self._blocks = {name: part for name, part in self._parts.items() if isinstance(part, Block)}
        self._methods = dict(self._all_methods())

    def note(self) -> None:
        """Note all facts of the class."""
        self._facts.reads_all = _uses_names(self._trees)
        self._facts.remarks["no-place"] += _misplaced(self._logic, self._spec, self._path)
        if not self._facts.remarks["no-place"]:  # otherwise, the used bits are unknown
            self._facts.uses_bit = _uses_bit(self._logic, self._trees)
        for axis in self._axes.values():
            _note_axis(axis, self._path, self._facts)
        for reader in self._readers:
            self._calls(reader)
            self._loops(reader)
            Flow(reader).note()
            note_names(reader)
            note_reals(reader)
        for variable in variables_of(self._logic, self._path, self._is_recorded):
            self._facts.variables[variable.name] = variable
            self._note_unnamed(variable)
        owners = self._summaries()  # needs the variables
        self._unknown_attributes()
        if len(self._readers) == 1 and not self._facts.reads_all:
            self._of_one_file(self._readers[0])
        self._zero_presets()
        self._called_twice()
        for name, (reader, function) in self._methods.items():
            if name not in owners and not function.name.startswith("__"):
                self._note_uncalled(reader, function)

    def _calls(self, reader: Reader) -> None:
        """Note axis calls and waits that fail, that are refused, or that have too short a time."""
        calls = Calls(reader, self._axes, type(self._logic).__mro__)
        self._facts.searches.extend(SentCommand(place, axis.slot) for place, axis in calls.searches())
        self._facts.remarks["out-of-range"] += calls.refused()
        self._facts.remarks["bad-call"] += calls.failing()
        for rule, call, text in calls.short_waits(self._spec.scan_ns):
            reader.remark(rule, call, text)
        note_short_times(reader, self._spec.scan_ns)

    def _loops(self, reader: Reader) -> None:
        """Note the loops that never wait, once per line."""
        inputs = [name for name, part in self._parts.items() if isinstance(part, Input | InputWord)]
        tree = reader.tree
        loops = [*endless(tree, inputs), *skips_wait(tree), *fixed_loops(tree, self._parts)]
        for line, text in dict(loops).items():
            self._facts.remark("never-waits", FileLine(reader.file, line), text)

    def _note_unnamed(self, field: Variable) -> None:
        """Note a field that is never used."""
        is_private = field.role is Role.PLAIN and not self._is_recorded(field.name)
        if is_private and field.name not in self._attributes and field.name not in self._constants:
            text = f"field {field.name} is declared, but nothing uses it"
            self._facts.remark("unused-tag", field.place, text)

    def _of_one_file(self, reader: Reader) -> None:
        """Note counters that never count, blocks that are never called, and the changes of steps."""
        recorded = [name for name in self._facts.variables if self._is_recorded(name)]
        note_counting(reader, recorded)
        never_called(reader, self._blocks)
        walk = Walk(reader)
        steps = PythonSteps(walk, Images(reader, self._spec), ())
        for statement, place in walk.statements():
            if isinstance(statement, ast.Assign):
                steps.note(statement, place)
        self._facts.actions += steps.changes
        self._facts.step_use, self._facts.first_steps = steps.use, steps.first

    def _summaries(self) -> Mapping[str, set[str]]:
        """Note the actions of sequences and uses of fields; return the sequences that reach each method."""
        locks = [name for name, part in self._parts.items() if isinstance(part, Lock)]
        numbers = {reader.file: Numbers(reader, _stored(reader, self._logic)) for reader in self._readers}
        summaries = SequenceSummaries(self._methods, self._axes, locks, numbers, self._facts)
        sequences = [sequence.name for sequence in sequences_of(self._logic)]
        for sequence in sequences:
            summaries.follow(sequence, sequence)
        summaries.follow("every_scan", "")
        self._facts.escaped = summaries.escaped()
        for reader, function in self._methods.values():
            self._note_lost_numbers(reader, function, numbers[reader.file])
            Accesses(reader, function, summaries.reached, sequences).note()
        return summaries.reached

    def _all_methods(self) -> Iterator[tuple[str, Method]]:
        """Yield the methods of the class and its bases, derived classes last."""
        for kind in reversed(type(self._logic).__mro__):
            for reader in self._readers:
                for function, owner in functions_in(reader.tree):
                    if owner is not None and owner.name == kind.__name__:
                        yield function.name, (reader, function)

    def _is_recorded(self, name: str) -> bool:
        return any(fnmatch(name, pattern.rpartition(".")[2]) for pattern in self._spec.tags)

    def _note_uncalled(self, reader: Reader, function: Function) -> None:
        """Note a helper that is never used."""
        is_entry = function.name == "every_scan" or function.decorator_list
        if function.name not in self._attributes and not is_entry:
            reader.remark("unreachable", function, f"nothing calls {function.name}")

    def _zero_presets(self) -> None:
        """Note blocks with a preset of 0."""
        for name, block in self._blocks.items():
            if (isinstance(block, Timer) and block.preset_ns == 0) or getattr(block, "preset", 1) == 0:
                text = f"{name}: its preset is 0, so it is done at once"
                self._facts.remark("preset-zero", place_at(block.declared, self._path), text)

    def _called_twice(self) -> None:
        """Note blocks that are called twice in a scan."""
        helpers = {method.name: method for _, method in self._methods.values()}
        callees = {field_of(call.func) for call in nodes_in(helpers.values(), ast.Call)}
        for reader, function in self._methods.values():
            is_helper = isinstance(function, ast.FunctionDef) and function.name in callees
            for call, name in () if is_helper else called_twice(function, self._blocks, helpers):
                problem = "the second call overrides the first, and edges are lost"
                text = f"{name} is called twice in {function.name}: {problem}"
                reader.remark("block-twice", call, text)

    def _note_lost_numbers(self, reader: Reader, function: Function, numbers: Numbers) -> None:
        """Note numbers that do not fit into their word."""
        for node in nodes_in(function, ast.Assign):
            for target in node.targets:
                part = self._parts.get(ast.unparse(target).removeprefix("self."))
                if isinstance(part, OutputWord):
                    loss = word_loss(node.value, numbers.range_of(node.value))
                    if loss:
                        reader.remark("lossy-conversion", node, f"{part.name}: {loss}")

    def _unknown_attributes(self) -> None:
        """Note attributes that do not exist."""
        attributes = {*dir(self._logic), *vars(self._logic), *self._methods}
        for kind in type(self._logic).__mro__:
            attributes.update(declared(vars(kind)))
        for reader, function in self._methods.values():
            if function.args.args and function.args.args[0].arg == "self":
                callee_ids = {id(node.func) for node in nodes_in(function, ast.Call)}
                for node in nodes_in(function, ast.Attribute):
                    names = self._names_of(node, attributes, called=id(node) in callee_ids)
                    if names is not None:
                        reader.remark_unless_in(names, node)

    def _names_of(self, node: ast.Attribute, fields: set[str], *, called: bool) -> set[str] | None:
        """Return the attributes of an attribute's owner; None if they are unknown, or if any name is legal.

        Args:
            fields: attributes of `self`.
        """
        match ast.unparse(node.value).split("."):
            case ["self"]:
                return fields if is_loaded(node) else None
            case ["self", name]:
                part = self._parts.get(name)
                is_command = isinstance(part, Axis3601) and called  # `calls` checks commands
                is_open = part is None or isinstance(part, InputWord | Output) or is_command
                return None if is_open else set(dir(part))
            case ["self", name, "status"]:
                part = self._parts.get(name)
                return set(dir(part.status)) if isinstance(part, Axis3601) else None
        return None


def _stored(reader: Reader, logic: Logic) -> dict[str, list[ast.expr | None]]:
    """Return the values that a text assigns to each field and local variable; None for unknown values."""
    values: dict[str, list[ast.expr | None]] = {}
    known_ids: set[int] = set()  # targets with a known value
    for target, value in _single_assignments(reader.tree):
        known_ids.add(id(target))
        values.setdefault(ast.unparse(target), []).append(value)
    for node in nodes_in(reader.tree, ast.Name, ast.Attribute, ast.arg):
        if isinstance(node, ast.arg):
            values.setdefault(node.arg, []).append(None)
        elif is_stored(node) and id(node) not in known_ids:
            values.setdefault(ast.unparse(node), []).append(None)
    for name, initial in fields_of(logic).items():
        if isinstance(initial, int) and f"self.{name}" in values and initial:
            values[f"self.{name}"].append(ast.parse(repr(int(initial)), mode="eval").body)
    return values


def _single_assignments(tree: ast.Module) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Yield the names and attributes that assignments set, each with its value or element of a value."""
    for target, value in assignments_in(tree):
        for index, element_target in enumerate(target.elts if isinstance(target, ast.Tuple) else [target]):
            if isinstance(element_target, ast.Name | ast.Attribute):
                element = ast.Subscript(value, ast.Constant(index), ast.Load())
                yield element_target, value if element_target is target else element


def _misplaced(logic: Logic, spec: RackSpec, path: Path) -> Iterator[Violation]:
    """Yield declarations that the rack lacks, or that are claimed twice."""
    slots = bare_slots({slot.number: slot.words for slot in spec.slot})
    try:
        logic.__attach_logic__(slots)
    except DeclarationError as error:
        for mistake in error.errors:
            place = place_at(next(sites_of(mistake), NOWHERE), path)
            yield Violation(place, mistake.reason if isinstance(mistake, SiteError) else str(mistake))


def _texts(program: type, path: Path) -> Iterator[tuple[Path, ast.Module, Mapping[str, Any]]]:
    """Yield the file, syntax tree and global names of each module that defines the class or a base."""
    files = set()
    for kind in program.__mro__:
        module = sys.modules.get(kind.__module__)
        file = getattr(module, "__file__", None)
        if file is None or not issubclass(kind, Logic) or kind is Logic or file in files:
            continue
        files.add(file)
        shown = path if Path(file).resolve() == path.resolve() else Path(file)  # as the user wrote it
        yield shown, ast.parse(read_input_text(shown, TextKind.PYTHON)), vars(module)


def _uses_bit(logic: Logic, texts: Sequence[ast.Module]) -> UsesBit:
    """Return a function that tests whether the class declares a bit, or its word, under a used name."""
    read = {node.attr for node in nodes_in(texts, ast.Attribute) if is_loaded(node)}
    used_names = {"I": read, "O": stored_attributes(texts)}
    may_use_all = _uses_names(texts)
    signals = ((part.name, part.at) for part in parts_of(logic) if isinstance(part, Signal))
    used_bits = {
        (signal.slot, signal.image, signal.word, signal.bit)
        for name, signal in signals
        if signal is not None and (may_use_all or name in used_names[signal.image])
    }

    def uses(slot: int, image: str, _name: str, word: int, bit: int) -> bool:
        return not used_bits.isdisjoint({(slot, image, word, bit), (slot, image, word, None)})

    return uses


def _uses_names(texts: Iterable[ast.AST]) -> bool:
    """Whether a text may compute the names of attributes that it uses."""
    return any(node.id in ("getattr", "setattr", "vars") for node in nodes_in(texts, ast.Name))


def _constant_fields(logic: Logic, texts: Sequence[ast.Module]) -> dict[str, object]:
    """Return the class attributes with plain values that no statement assigns to, by name."""
    kinds = [kind for kind in type(logic).__mro__ if issubclass(kind, Logic)]
    names = dict.fromkeys(name for kind in kinds for name in vars(kind)).keys() - stored_attributes(texts)
    values = {name: getattr_static(type(logic), name) for name in names}
    return {name: value for name, value in values.items() if isinstance(value, int | str | tuple)}
