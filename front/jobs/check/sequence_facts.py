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
from inspect import getattr_static
from pathlib import Path
from typing import Any

from ...io_images.site import NOWHERE, Site, SiteError, sites_of
from ...ladder.python.axis3601 import Axis3601
from ...ladder.python.sequences import Input, InputWord, Logic, fresh, parts_of
from ...ladder.python.sequences.parts import DeclarationError
from ...ladder.python.sequences.signals import Signal
from ...runtime.config.rackspec import RackSpec
from ..load.bare_slots import bare_slots
from .facts import Facts, FileLine, Remark, SentCommand, UsesBit
from .loops import endless
from .python_facts import Reader
from .sequence_calls import Calls


def sequence_facts(path: Path, program: Logic, spec: RackSpec) -> Facts:
    """Read the facts of a program with sequences, from an instance of its class."""
    logic = fresh(program)
    texts = list(_texts(type(program), path))
    facts = Facts(not_seen=["values that the program computes"])
    facts.misplaced.extend(_misplaced(logic, spec, path))
    if not facts.misplaced:
        facts.uses_bit = _uses_bit(logic, [tree for _, tree, _ in texts])
    axes = {each.name: each for each in parts_of(logic) if isinstance(each, Axis3601)}
    fields = _constant_fields(logic, [tree for _, tree, _ in texts])
    inputs = [each.name for each in parts_of(logic) if isinstance(each, Input | InputWord)]
    for axis in axes.values():
        words = tuple(axis.configuration.to_image().words.tolist())
        facts.configurations.append(SentCommand(_place(axis.declared, path), axis.slot, words))
    for file, tree, names in texts:
        calls = Calls(Reader(str(file), tree, names, fields), axes, type(program).__mro__)
        facts.searches.extend(SentCommand(place, axis.slot) for place, axis in calls.searches())
        facts.out_of_range.extend(calls.refused())
        facts.misused.extend(calls.failing())
        facts.endless.extend(Remark(FileLine(str(file), line), text) for line, text in endless(tree, inputs))
    return facts


def _misplaced(logic: Logic, spec: RackSpec, path: Path) -> Iterator[Remark]:
    """Yield declarations that the rack lacks, or that two owners claim."""
    slots = bare_slots({slot.number: slot.words for slot in spec.slot})
    try:
        logic.__attach_logic__(slots)
    except DeclarationError as error:
        for each in error.errors:
            site = next(sites_of(each), NOWHERE)
            yield Remark(_place(site, path), each.reason if isinstance(each, SiteError) else str(each))


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
        yield own, ast.parse(own.read_text("utf-8")), vars(module)


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
