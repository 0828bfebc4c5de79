"""Facts of a program with sequences, from the declarations of its class and from its text.

    axis = Axis3601(1, Configuration(...))        the configuration of slot 1
    start = Input("Local:2:I.Data.0")             a place, which the rack has or lacks
    await self.axis.move_to(9_000_000, ...)       a command with constants; unknown values are legal
    while True: self.count += 1                   a loop that never waits

No sequence runs. The class is attached to images without modules.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatch
from inspect import getattr_static
from pathlib import Path
from typing import Any

from scanrack.io_images.amci3601 import Configuration
from scanrack.io_images.annotations import declared
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.site import NOWHERE, Site, SiteError, sites_of
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
from ..facts import Facts, FileLine, LocalFinding, Role, SentCommand, UsesBit, Variable
from ..rungs.accesses import declaration_lines
from .attributes import note_names
from .calls import Calls
from .counting import never_called, note_counting
from .flow import Flow
from .images import Images
from .loops import endless, fixed_loops, skips_wait
from .names import Accesses, called_twice, variables_of
from .numbers import Numbers
from .reader import Function, Reader, field_of, functions_in
from .reals import note_reals
from .scans import missing, word_lost
from .sequence_summaries import SequenceSummaries
from .steps import PythonSteps
from .times import waits_below_one_scan


def sequence_facts(path: Path, program: Logic, spec: RackSpec) -> Facts:
    """Read the facts of a program with sequences, from an instance of its class."""
    logic = fresh(program)
    texts = list(_texts(type(program), path))
    facts = Facts(not_seen=["values that the program computes"])
    facts.remarks["no-place"] += _misplaced(logic, spec, path)
    if not facts.remarks["no-place"]:
        facts.uses_bit = _uses_bit(logic, [tree for _, tree, _ in texts])
    parts = {each.name: each for each in parts_of(logic)}
    axes = {name: each for name, each in parts.items() if isinstance(each, Axis3601)}
    fields = _constant_fields(logic, [tree for _, tree, _ in texts])
    inputs = [name for name, each in parts.items() if isinstance(each, Input | InputWord)]
    for axis in axes.values():
        if isinstance(axis.configuration, Configuration):  # the rules read the words of a 3601
            words = tuple(axis.configuration.to_image().words.tolist())
            facts.configurations.append(SentCommand(_place(axis.declared, path), axis.slot, words))
        if not axis.parameters_first:
            text = f"{axis.name} sends each command together with its parameters"
            facts.at_once.append(LocalFinding(_place(axis.declared, path), text))
    readers = {str(file): Reader(str(file), tree, names, fields) for file, tree, names in texts}
    for file, reader in readers.items():
        calls = Calls(reader, axes, type(program).__mro__)
        facts.searches.extend(SentCommand(place, axis.slot) for place, axis in calls.searches())
        facts.remarks["out-of-range"] += calls.refused()
        facts.remarks["bad-call"] += calls.failing()
        facts.remarks["preset-zero"] += calls.without_time()
        facts.remarks["preset-unit"] += calls.waits_below_one_scan(spec.scan_ns)
        for node, text in waits_below_one_scan(reader, spec.scan_ns):
            facts.remark("preset-unit", FileLine(file, node.lineno), text)
        loops = [*endless(reader.tree, inputs), *skips_wait(reader.tree), *fixed_loops(reader.tree, parts)]
        loops = list(dict(loops).items())  # one per line
        facts.remarks["never-waits"] += (LocalFinding(FileLine(file, line), text) for line, text in loops)
        Flow(reader, facts).note()
        note_names(reader, facts)
        note_reals(reader, facts)
    _SequenceReader(logic, readers, spec, path, facts).note()
    return facts


class _SequenceReader:
    """Reads what the methods of a class do with its fields, terminals, axes and locks."""

    def __init__(
        self, logic: Logic, readers: Mapping[str, Reader], spec: RackSpec, path: Path, facts: Facts
    ) -> None:
        self._logic, self._readers, self._spec, self._path, self._facts = logic, readers, spec, path, facts
        self._parts = {each.name: each for each in parts_of(logic)}
        self._methods = dict(self._all_methods())

    def note(self) -> None:
        """Note all of it."""
        texts = [reader.tree for reader in self._readers.values()]
        nodes = [node for tree in texts for node in ast.walk(tree)]
        self._facts.reads_all = any(
            isinstance(node, ast.Name) and node.id in ("getattr", "setattr", "vars") for node in nodes
        )
        own = FileLine(str(self._path), 1)
        lines = declaration_lines(self._path)
        for each in variables_of(self._logic, own, self._is_recorded, lines):
            self._facts.variables[each.name] = each
            self._unnamed(each, nodes)
        self._stories()
        self._attributes()
        self._counters()
        self._steps()
        for name, (file, function) in self._methods.items():
            self._blocks(file, function)
            if name not in self._owners and not function.name.startswith("__"):
                self._unused(file, function)

    def _unnamed(self, field: Variable, nodes: Sequence[ast.AST]) -> None:
        """Note a field that nothing names."""
        named = (node for node in nodes if isinstance(node, ast.Attribute | ast.Constant))
        is_unnamed = all(getattr(node, "attr", getattr(node, "value", None)) != field.name for node in named)
        if is_unnamed and field.role is Role.PLAIN and not self._is_recorded(field.name):
            text = f"field {field.name} is declared, and nothing names it"
            self._facts.remark("unused-tag", field.place, text)

    def _steps(self) -> None:
        """Note the steps of a number or a text of a class in one file, without what they command."""
        if len(self._readers) > 1 or self._facts.reads_all:
            return
        for reader in self._readers.values():
            steps = PythonSteps(reader, Images(reader, self._spec, Facts()), ())
            self._facts.actions += steps.actions()
            self._facts.step_use, self._facts.first_steps = steps.use, steps.first

    def _counters(self) -> None:
        """Note counters and blocks that nothing runs, of a class in one file."""
        if len(self._readers) > 1 or self._facts.reads_all:
            return
        recorded = [name for name in self._facts.variables if self._is_recorded(name)]
        blocks = [name for name, each in self._parts.items() if isinstance(each, Block)]
        for reader in self._readers.values():
            note_counting(reader, self._facts, recorded)
            never_called(reader, blocks, self._facts)

    def _stories(self) -> None:
        axes = {name: each for name, each in self._parts.items() if isinstance(each, Axis3601)}
        locks = [name for name, each in self._parts.items() if isinstance(each, Lock)]
        numbers = {
            file: Numbers(reader, _stored(reader, self._logic)) for file, reader in self._readers.items()
        }
        stories = SequenceSummaries(self._methods, axes, locks, numbers, self._facts)
        sequences = [each.name for each in sequences_of(self._logic)]
        for each in sequences:
            stories.tell(each, each)
        stories.tell("every_scan", "")
        self._owners = stories.reached
        self._facts.escaped = stories.escaped()
        self._words(numbers)
        accesses = Accesses(self._facts, stories.reached, sequences)
        for file, function in self._methods.values():
            accesses.note(file, function)

    def _all_methods(self) -> Iterator[tuple[str, tuple[str, Function]]]:
        """Yield the methods of the class and its bases, the derived ones last."""
        names = [kind.__name__ for kind in reversed(type(self._logic).__mro__)]
        for name in names:
            for file, reader in self._readers.items():
                for function, owner in functions_in(reader.tree):
                    if owner is not None and owner.name == name:
                        yield function.name, (file, function)

    def _is_recorded(self, name: str) -> bool:
        return any(fnmatch(name, pattern.rpartition(".")[2]) for pattern in self._spec.tags)

    def _unused(self, file: str, function: Function) -> None:
        """Note a helper that nothing names."""
        trees = [reader.tree for reader in self._readers.values()]
        named = {node.attr for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
        if function.name not in named and function.name != "every_scan" and not function.decorator_list:
            text = f"nothing calls {function.name}"
            self._facts.remark("unreachable", FileLine(file, function.lineno), text)

    def _blocks(self, file: str, function: Function) -> None:
        blocks = {name: each for name, each in self._parts.items() if isinstance(each, Block)}
        helpers = {each.name: each for _, each in self._methods.values()}
        nodes = [node for each in helpers.values() for node in ast.walk(each) if isinstance(node, ast.Call)]
        is_own = isinstance(function, ast.FunctionDef)  # its calls are those of what calls it
        is_called = is_own and function.name in {field_of(each.func) for each in nodes}
        for call, name in () if is_called else called_twice(function, blocks, helpers):
            text = f"{name} is called twice in {function.name}: the second call counts, and edges are lost"
            self._facts.remark("block-twice", FileLine(file, call.lineno), text)
        for name, each in blocks.items():
            is_zero = (isinstance(each, Timer) and each.preset_ns == 0) or getattr(each, "preset", 1) == 0
            if is_zero and function.name == next(iter(self._methods.values()))[1].name:
                text = f"{name}: its preset is 0, so it is done at once"
                self._facts.remark("preset-zero", _place(each.declared, self._path), text)

    def _words(self, numbers: Mapping[str, Numbers]) -> None:
        """Note words that are given another number than they can hold."""
        for file, function in self._methods.values():
            for node in ast.walk(function):
                targets = node.targets if isinstance(node, ast.Assign) else []
                for target in targets:
                    part = self._parts.get(ast.unparse(target).removeprefix("self."))
                    if isinstance(part, OutputWord) and isinstance(node, ast.Assign):
                        text = word_lost(node.value, numbers[file].of(node.value))
                        if text:
                            self._facts.remark(
                                "lossy-conversion", FileLine(file, node.lineno), f"{part.name}: {text}"
                            )

    def _attributes(self) -> None:
        """Note attributes that do not exist."""
        known = {*dir(self._logic), *(name for name in vars(self._logic)), *self._methods}
        for kind in type(self._logic).__mro__:
            known.update(declared(vars(kind)))
        for file, function in self._methods.values():
            if function.args.args and function.args.args[0].arg == "self":
                called = {id(node.func) for node in ast.walk(function) if isinstance(node, ast.Call)}
                for node in ast.walk(function):
                    if isinstance(node, ast.Attribute):
                        self._attribute(node, file, known, called=id(node) in called)

    def _attribute(self, node: ast.Attribute, file: str, known: set[str], *, called: bool) -> None:
        owner, text = ast.unparse(node.value), ""
        if owner == "self" and node.attr not in known and isinstance(node.ctx, ast.Load):
            text = missing(f"self.{node.attr}", node.attr, known)
        elif owner.startswith("self.") and owner.count(".") == 1:
            part = self._parts.get(owner.removeprefix("self."))
            is_command = isinstance(part, Axis3601) and called  # see `calls`
            if part is not None and not isinstance(part, InputWord | Output) and not is_command:
                names = set(dir(part))
                text = "" if node.attr in names else missing(f"{owner}.{node.attr}", node.attr, names)
        elif owner.startswith("self.") and owner.endswith(".status") and owner.count(".") == 2:
            part = self._parts.get(owner.split(".")[1])
            names = set(dir(part.status)) if isinstance(part, Axis3601) else {node.attr}
            text = "" if node.attr in names else missing(f"{owner}.{node.attr}", node.attr, names)
        if text:
            self._facts.remark("unknown-attribute", FileLine(file, node.lineno), text)


def _stored(reader: Reader, logic: Logic) -> dict[str, list[ast.expr | None]]:
    """Return what a text assigns to each field and each local variable; None for what is not a value."""
    found: dict[str, list[ast.expr | None]] = {}
    simple: set[int] = set()
    for node in ast.walk(reader.tree):
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                parts = target.elts if isinstance(target, ast.Tuple) else [target]
                for at, each in enumerate(parts):
                    element = ast.Subscript(node.value, ast.Constant(at), ast.Load())
                    if isinstance(each, ast.Name | ast.Attribute):
                        simple.add(id(each))
                        stored = node.value if each is target else element
                        found.setdefault(ast.unparse(each), []).append(stored)
    for node in ast.walk(reader.tree):
        if (
            isinstance(node, ast.Name | ast.Attribute)
            and isinstance(node.ctx, ast.Store)
            and id(node) not in simple
        ):
            found.setdefault(ast.unparse(node), []).append(None)
        elif isinstance(node, ast.arg):
            found.setdefault(node.arg, []).append(None)
    for name, value in fields_of(logic).items():
        if isinstance(value, int) and f"self.{name}" in found and value:
            found[f"self.{name}"].append(ast.parse(repr(int(value)), mode="eval").body)
    return found


def _misplaced(logic: Logic, spec: RackSpec, path: Path) -> Iterator[LocalFinding]:
    """Yield declarations that the rack lacks, or that two owners claim."""
    slots = bare_slots({slot.number: slot.words for slot in spec.slot})
    try:
        logic.__attach_logic__(slots)
    except DeclarationError as error:
        for each in error.errors:
            site = next(sites_of(each), NOWHERE)
            yield LocalFinding(_place(site, path), each.reason if isinstance(each, SiteError) else str(each))


def _texts(program: type, path: Path) -> Iterator[tuple[Path, ast.Module, Mapping[str, Any]]]:
    """Yield file, text and names of the modules of a class and of its bases."""
    seen = set()
    for kind in program.__mro__:
        module = sys.modules.get(kind.__module__)
        file = getattr(module, "__file__", None)
        if file is None or not issubclass(kind, Logic) or kind is Logic or file in seen:
            continue
        seen.add(file)
        own = path if Path(file).resolve() == path.resolve() else Path(file)
        yield own, ast.parse(read_input_text(own, TextKind.PYTHON)), vars(module)


def _uses_bit(logic: Logic, texts: Sequence[ast.Module]) -> UsesBit:
    """Return whether the class declares a bit, or its word, under a name that its text uses."""
    nodes = [node for tree in texts for node in ast.walk(tree)]
    named = [node for node in nodes if isinstance(node, ast.Attribute)]
    stored = {node.attr for node in named if isinstance(node.ctx, ast.Store)}
    read = {node.attr for node in named if isinstance(node.ctx, ast.Load)}
    by_name = any(isinstance(node, ast.Name) and node.id in ("getattr", "setattr", "vars") for node in nodes)
    places = {
        (each.at.slot, each.at.image, each.at.word, each.at.bit)
        for each in parts_of(logic)
        if isinstance(each, Signal)
        and each.at is not None
        and (by_name or each.name in (stored if each.at.image == "O" else read))
    }

    def uses(slot: int, image: str, _name: str, word: int, bit: int) -> bool:
        return not places.isdisjoint({(slot, image, word, bit), (slot, image, word, None)})

    return uses


def _constant_fields(logic: Logic, texts: Sequence[ast.Module]) -> dict[str, object]:
    """Return the plain values in the body of the class that its text never changes, by name."""
    stored = {
        node.attr
        for tree in texts
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
    }
    bodies = [name for kind in type(logic).__mro__ if issubclass(kind, Logic) for name in vars(kind)]
    values = {name: getattr_static(type(logic), name) for name in bodies if name not in stored}
    return {name: value for name, value in values.items() if isinstance(value, int | str | tuple)}


def _place(site: Site, path: Path) -> FileLine:
    return FileLine(site.file or str(path), site.line or 1)
