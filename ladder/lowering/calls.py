"""Arguments of add-on calls: the instance, and the checked argument of every InOut."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from scanrack.io_images.drives.models import Layout
from scanrack.io_images.drives.translation import model_of
from scanrack.io_images.module_words import ModuleWords

from ..model.operand_checks import OperandError, described
from ..model.operands import Constant, Group, Place, first_leaf
from ..model.resolver import AddressError, Resolver
from ..model.tags import OPEN, Tag
from ..model.tree import Address, Instruction, Number, Operand, Series, SubscriptStep
from ..model.types import Elementary, Structure
from .addon import AddOn


def with_stored_subscripts(resolver: Resolver, instance: Operand) -> tuple[Address, tuple[Series, ...]]:
    """Return an instance with its subscripts stored for the call, and the rungs that store them."""
    assert isinstance(instance, Address)
    rungs: list[Series] = []

    def stored(index: Operand) -> Operand:
        """Return the tag that stores a subscript, or a constant subscript itself."""
        if isinstance(index, Number) or isinstance(resolver.operand(index), Constant):
            return index
        storage = Address(resolver.hold())
        rungs.append((Instruction("CPT", (storage, index)),))
        return storage

    steps = tuple(
        SubscriptStep(tuple(map(stored, step.indices))) if isinstance(step, SubscriptStep) else step
        for step in instance.steps
    )
    return replace(instance, steps=steps), tuple(rungs)


def inout_arguments(
    definition: AddOn, arguments: Mapping[str, Address], resolver: Resolver
) -> dict[str, Place | Group]:
    """Return the arguments of the InOuts by name in capitals, or raise an OperandError."""
    inouts = {inout.name: inout for inout in definition.inouts}
    arguments_by_name = {}
    for name, argument in arguments.items():
        resolved = _resolve_argument(inouts[name], argument, resolver)
        _check_argument(definition, inouts[name], argument, resolved)
        arguments_by_name[name.upper()] = resolved
    return arguments_by_name


OWNER = "AMCI3601"
"""The add-on instruction that owns a module's words, in capitals."""

MODEL = "Model"
"""The parameter of `OWNER` for the model of a networked drive."""

_MODELS = {Layout.SMD: 1, Layout.ANF2: 2}


def model_number(words: ModuleWords | None) -> int:
    """Return a module's `MODEL` value (see `files.drive_blocks`); 0 unless it is a networked drive."""
    model = None if words is None else model_of(words)
    return 0 if model is None else _MODELS[model.layout]


MODULE = "MODULE"
"""Type of an InOut that accepts a module's name."""

MODULE_TAG = "scanrack_module_"
"""Prefix of a module's tag if another tag has the module's name."""


def _resolve_argument(inout: Tag, argument: Address, resolver: Resolver) -> Place | Group:
    """Resolve an argument; for an InOut of type MODULE, a module's name has precedence over a tag's name."""
    if inout.type.name.upper() == MODULE and not argument.steps:
        try:
            return resolver.address(Address(f"{MODULE_TAG}{argument.name}"))
        except AddressError:
            pass  # no tag has the name of the module
    return resolver.address(argument)


def _check_argument(definition: AddOn, required: Tag, argument: Address, resolved: Place | Group) -> None:
    """Raise an OperandError if an argument's type, dimensions or memory do not fit the InOut."""
    if resolved.type != required.type or not _has_dims(required.dims, resolved):
        raise OperandError(
            f"{required.name} of {definition.name} is {_kind(required)}, {argument} is {described(resolved)}",
            "pass a tag of that type",
        )
    leaf = first_leaf(resolved)
    if leaf.path.startswith("S:"):
        raise OperandError(f"{argument} is a status flag", "copy it to a tag, and pass the tag")
    if leaf.slot is not None and isinstance(resolved.type, Structure):
        raise OperandError(f"{argument} is a whole module", "pass its Data, or a copy of it")


def _has_dims(required: tuple[int, ...], resolved: Place | Group) -> bool:
    """Return whether an argument fits the dimensions of an InOut; a row can be longer than required."""
    dims = resolved.dims
    if len(required) == 1:
        return len(dims) == 1 and (required[0] == OPEN or required[0] <= dims[0])
    # a whole array means its first element, as in COP
    return dims == required or not required


def _kind(required: Tag) -> str:
    dims = ",".join("any" if length == OPEN else str(length) for length in required.dims)
    name = required.type.name
    article = "an" if isinstance(required.type, Elementary) and name[0] in "AEIOU" else "a"
    return f"{name}[{dims}]" if dims else f"{article} {name}"
