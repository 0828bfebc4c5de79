"""Exports a program or a routine as an L5X for partial import into Studio 5000.

The exported object is the target; tags, data types and add-on instructions are its context. An import of the
file returns the same tree.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from lxml import etree
from scanrack.ladder.lowering.addon import (
    ENABLES,
    OTHERWISE,
    POSTSCAN,
    PRESCAN,
    AddOn,
    Parameter,
    ParameterMode,
)
from scanrack.ladder.lowering.controller import Controller
from scanrack.ladder.lowering.program import Program
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.predefined.structures import PREDEFINED_TYPES
from scanrack.ladder.model.quoting import quoted
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.statements import block_lines
from scanrack.ladder.model.tags import Alias, Declaration, SlotAlias, Tag
from scanrack.ladder.model.types import DataType, Elementary, Member, Structure

from .chart_export import write_chart
from .mnemonics import OWN
from .xml.records import ElementRecord
from .xml.writing import cdata, element, flag, text_element, write_statements

REVISION = "32.02"
"""Software revision of the exported file; later revisions can import it."""

_USAGES = {ParameterMode.INPUT: "Input", ParameterMode.OUTPUT: "Output", ParameterMode.INOUT: "InOut"}
_CONTEXT = {"Use": "Context"}
_TARGET = {"Use": "Target"}


def export_l5x(logic: Program | Controller, name: str) -> bytes:
    """Return a program (`Main`) or routine (`Main.Sequence`) as an L5X.

    Raises:
        LadderError: the program or routine does not exist, or an L5X can't contain it.
    """
    owner, _, routine_name = name.partition(".")
    program = _find("program", owner, logic.programs if isinstance(logic, Controller) else [logic])
    routines = [_find("routine", routine_name, program.routines)] if routine_name else list(program.routines)
    _check_instructions(logic, routines)
    root = element(
        None,
        "RSLogix5000Content",
        SchemaRevision="1.0",
        SoftwareRevision=REVISION,
        TargetName=routines[0].name if routine_name else program.name,
        TargetType="Routine" if routine_name else "Program",
        ContainsContext="true",
        ExportOptions="References NoRawData DecoratedData Context Dependencies AllProjDocTrans",
    )
    controller = element(root, "Controller", Name=logic.name, **_CONTEXT)
    outer = logic.declarations if isinstance(logic, Controller) else []
    _write_types(controller, _used_types(logic, [*outer, *program.declarations]))
    _write_add_ons(controller, logic.add_ons.values())
    _write_tags(element(controller, "Tags", **_CONTEXT), outer)
    _write_program(element(controller, "Programs", **_CONTEXT), program, routines, whole=not routine_name)
    return bytes(
        etree.tostring(root, xml_declaration=True, encoding="UTF-8", standalone=True, pretty_print=True)
    )


def _check_instructions(logic: Program | Controller, routines: Iterable[Routine]) -> None:
    """Raise a LadderError for an instruction that no controller has."""
    definitions = [add_on_routine for add_on in logic.add_ons.values() for add_on_routine in add_on.routines]
    for routine in (*routines, *definitions):
        for name in sorted(OWN - logic.add_ons.keys()):
            if re.search(rf"\b{name}\(", routine.text):
                raise LadderError(
                    f"routine {routine.name} has {name}, which no controller has: keep it in test routines"
                )


def _find(kind: str, name: str, candidates: Sequence[Any]) -> Any:
    """Return the candidate with a name, in any case; raise a LadderError that lists the names."""
    for candidate in candidates:
        if candidate.name.upper() == name.upper():
            return candidate
    names = ", ".join(candidate.name for candidate in candidates) or "none"
    raise LadderError(f"no {kind} {name!r}; choose from {names}")


# --- types


def _used_types(logic: Program | Controller, declarations: Iterable[Declaration]) -> Iterator[Structure]:
    """Yield the structures that declarations and add-ons use, inner ones first, except types of modules."""
    done = {*PREDEFINED_TYPES, *(add_on.name for add_on in logic.add_ons.values())}
    kinds: list[DataType] = [declaration.type for declaration in declarations if isinstance(declaration, Tag)]
    kinds += [parameter.type for definition in logic.add_ons.values() for parameter in definition.parameters]

    def walk(kind: DataType) -> Iterator[Structure]:
        """Yield a structure after the structures of its members, each only once."""
        if isinstance(kind, Structure) and kind.name not in done and ":" not in kind.name:
            done.add(kind.name)
            for member in kind.members:
                yield from walk(member.type)
            yield kind

    for kind in kinds:
        yield from walk(kind)


def _write_types(controller: Any, kinds: Iterable[Structure]) -> None:
    """Add the definitions of structures."""
    parent = element(controller, "DataTypes", **_CONTEXT)
    for kind in kinds:
        family = "StringFamily" if kind.is_string else "NoFamily"
        type_element = element(parent, "DataType", Name=kind.name, Family=family, Class="User")
        members = element(type_element, "Members")
        for member in kind.members:
            _write_member(members, kind, member)


def _write_member(members: Any, kind: Structure, member: Member) -> None:
    """Add a member of a structure; an alias must be a bit of another member, which is its host."""
    host, _, bit = member.at.rpartition(".")
    if member.at and not (member.type.name == "BOOL" and kind.member(host) and bit.isdigit()):
        raise LadderError(f"{member.name} of {kind.name} is at {member.at}: it must be a bit of a member")
    packed = {"Target": host, "BitNumber": bit} if member.at else {}
    element(
        members,
        "Member",
        Name=member.name,
        DataType="BIT" if member.at else member.type.name,
        Dimension=str(member.dims[0]) if member.dims else "0",
        Radix=_radix(member.type),
        Hidden=flag(member.hidden),
        **packed,
    )


def _radix(kind: DataType) -> str:
    """Return the display format of a type in Studio 5000."""
    if isinstance(kind, Structure):
        return "NullType"
    return "Decimal" if kind.is_bool or kind.is_integer else "Float"


# --- add-on instructions


def _write_add_ons(controller: Any, definitions: Iterable[AddOn]) -> None:
    """Add each add-on with EnableIn and EnableOut, its parameters, its local tags, and its routines."""
    parent = element(controller, "AddOnInstructionDefinitions", **_CONTEXT)
    for definition in definitions:
        add_on_element = element(
            parent,
            "AddOnInstructionDefinition",
            Name=definition.name,
            Revision="1.0",
            ExecutePrescan=flag(definition.routine(PRESCAN) is not None),
            ExecutePostscan=flag(definition.routine(POSTSCAN) is not None),
            ExecuteEnableInFalse=flag(definition.routine(OTHERWISE) is not None),
        )
        text_element(add_on_element, "Description", definition.comment)
        parameters, local = element(add_on_element, "Parameters"), element(add_on_element, "LocalTags")
        for name, usage in zip(ENABLES, ("Input", "Output"), strict=True):
            element(
                parameters,
                "Parameter",
                Name=name,
                TagType="Base",
                DataType="BOOL",
                Usage=usage,
                Required="false",
            )
        for parameter in definition.parameters:
            _write_parameter(local if parameter.mode is ParameterMode.LOCAL else parameters, parameter)
        routines = element(add_on_element, "Routines")
        for routine in definition.routines:
            _write_routine(routines, routine)


def _write_parameter(parent: Any, parameter: Parameter) -> None:
    """Add a parameter, or a local tag, with its comment and its default."""
    attributes = {"DataType": parameter.type.name}
    if parameter.at:
        attributes = {"TagType": "Alias", "AliasFor": parameter.at}
    elif parameter.mode is not ParameterMode.LOCAL:
        attributes["TagType"] = "Base"
    if parameter.dims:
        attributes["Dimensions"] = " ".join(map(str, parameter.dims))
    if parameter.mode is ParameterMode.LOCAL:
        parameter_element = element(parent, "LocalTag", Name=parameter.name, **attributes)
    else:
        attributes |= {"Usage": _USAGES[parameter.mode], "Required": flag(parameter.required)}
        parameter_element = element(parent, "Parameter", Name=parameter.name, **attributes)
    text_element(parameter_element, "Description", parameter.comment)
    _write_data(parameter_element, "DefaultData", parameter.type, parameter.dims, parameter.initial)


# --- tags and their values


def _write_tags(parent: Any, declarations: Iterable[Declaration]) -> None:
    """Add tags and aliases, except tags of modules; raise a LadderError for an alias of module data."""
    for declaration in declarations:
        if isinstance(declaration, SlotAlias) or (isinstance(declaration, Alias) and declaration.type):
            raise LadderError(
                f"{declaration.name} is an alias of module data, which an L5X lacks: use Local:slot:I.Data"
            )
        if isinstance(declaration, Alias):
            tag_element = element(
                parent, "Tag", Name=declaration.name, TagType="Alias", AliasFor=str(declaration.target)
            )
            text_element(tag_element, "Description", declaration.comment)
            continue
        if ":" in declaration.name:
            continue  # a tag of a module, which defines it in the controller
        dims = {"Dimensions": " ".join(map(str, declaration.dims))} if declaration.dims else {}
        tag_element = element(
            parent,
            "Tag",
            Name=declaration.name,
            TagType="Base",
            DataType=declaration.type.name,
            **dims,
            Constant="false",
        )
        text_element(tag_element, "Description", declaration.comment)
        _write_data(tag_element, "Data", declaration.type, declaration.dims, declaration.initial)


def _write_data(parent: Any, name: str, kind: DataType, dims: tuple[int, ...], initial: Any) -> None:
    """Add an initial value as decorated data, unless it is zero."""
    if initial is not None:
        _write_value(element(parent, name, Format="Decorated"), kind, dims, initial)


def _write_value(
    parent: Any, kind: DataType, dims: tuple[int, ...], value: Any, member: str | None = None
) -> None:
    """Add the value of a tag, or of a structure's member; None means zero."""
    suffix, attributes = ("", {}) if member is None else ("Member", {"Name": member})
    attributes["DataType"] = kind.name
    if dims:
        array = element(parent, f"Array{suffix}", **attributes, Dimensions=_joined(dims))
        _write_array(array, kind, dims, value)
    elif isinstance(kind, Structure):
        _write_structure(element(parent, f"Structure{suffix}", **attributes), kind, value)
    else:
        element(parent, f"DataValue{suffix}", **attributes, Radix=_radix(kind), Value=_number(kind, value))


def _joined(dims: tuple[int, ...]) -> str:
    return ",".join(map(str, dims))


def _write_array(
    parent: Any, kind: DataType, dims: tuple[int, ...], values: Any, outer_index: tuple[int, ...] = ()
) -> None:
    """Add the elements of an array, or of one of its rows; missing values are zero."""
    for number in range(dims[0]):
        value = values[number] if isinstance(values, list) and number < len(values) else None
        index = (*outer_index, number)
        if len(dims) > 1:
            _write_array(parent, kind, dims[1:], value, index)
        elif isinstance(kind, Structure):
            array_element = element(parent, "Element", Index=f"[{_joined(index)}]")
            _write_structure(element(array_element, "Structure", DataType=kind.name), kind, value)
        else:
            element(parent, "Element", Index=f"[{_joined(index)}]", Value=_number(kind, value))


def _write_structure(parent: Any, kind: Structure, value: Any) -> None:
    """Add the members of a structure's value; a bit without a value uses its host's value."""
    if kind.is_string:
        _write_string(parent, kind, value)
        return
    members = value if isinstance(value, dict) else {}
    values = {name.upper(): member_value for name, member_value in members.items()}
    for member in kind.members:
        if member.hidden:
            continue
        member_value = values.get(member.name.upper())
        if member.at and member_value is None:
            host, _, bit = member.at.rpartition(".")
            member_value = int(values.get(host.upper()) or 0) >> int(bit) & 1
        _write_value(parent, member.type, member.dims, member_value, member.name)


def _write_string(parent: Any, kind: Structure, value: Any) -> None:
    """Add the length and the characters of a string."""
    text = value if isinstance(value, str) else ""
    element(parent, "DataValueMember", Name="LEN", DataType="DINT", Radix="Decimal", Value=str(len(text)))
    data = element(parent, "DataValueMember", Name="DATA", DataType=kind.name, Radix="ASCII")
    data.text = cdata(quoted(text))


def _number(kind: DataType, value: Any) -> str:
    assert isinstance(kind, Elementary)
    if kind.is_bool or kind.is_integer:
        return str(int(value or 0))
    return repr(float(value or 0))


# --- programs and routines


def _write_program(parent: Any, program: Program, routines: Sequence[Routine], *, whole: bool) -> None:
    """Add a program with these routines; if it is not whole, the target is the only routine."""
    roots = {"MainRoutineName": program.main, "FaultRoutineName": program.fault} if whole else {}
    if whole and not program.main and routines:
        roots["MainRoutineName"] = routines[0].name
    program_element = element(
        parent,
        "Program",
        **(_TARGET if whole else _CONTEXT),
        Name=program.name,
        **{name: value for name, value in roots.items() if value},
    )
    _write_tags(element(program_element, "Tags"), _without_generated(program))
    parent = element(program_element, "Routines", **({} if whole else _CONTEXT))
    for routine in routines:
        _write_routine(parent, routine, target=not whole)


def _without_generated(program: Program) -> Iterator[Declaration]:
    """Yield the tags of a program, except the tags generated for its diagrams."""
    prefixes = tuple(f"FBD_{routine.name}_".upper() for routine in program.routines if routine.drawing)
    for declaration in program.declarations:
        if not declaration.name.upper().startswith(prefixes):
            yield declaration


def _write_routine(parent: Any, routine: Routine, *, target: bool = False) -> None:
    """Add a routine as a chart, a diagram, structured text, or rungs; `target` marks the exported one."""
    if routine.drawing is not None:
        kind = "FBD"
    elif routine.chart is not None:
        kind = "SFC"
    else:
        kind = "RLL" if routine.statements is None else "ST"
    routine_element = element(parent, "Routine", **(_TARGET if target else {}), Name=routine.name, Type=kind)
    text_element(routine_element, "Description", routine.comment)
    if routine.chart is not None:
        write_chart(routine_element, routine.chart)
    elif routine.drawing is not None:
        _write_drawing(routine_element, routine.drawing.record)
    elif routine.statements is not None:
        write_statements(routine_element, block_lines(routine.statements))
    else:
        content = element(routine_element, "RLLContent")
        for number, rung in enumerate(routine.rungs):
            rung_element = element(content, "Rung", Number=str(number), Type="N")
            text_element(rung_element, "Comment", rung.comment)
            element(rung_element, "Text").text = cdata(str(rung))


def _write_drawing(parent: Any, record: ElementRecord) -> None:
    """Add the content of a function block diagram, unchanged since it was read."""
    drawing_element = element(parent, record.tag, **record.attributes)
    if record.text.strip():
        drawing_element = element(drawing_element, "Text") if record.tag == "TextBox" else drawing_element
        drawing_element.text = cdata(record.text)
    for child in record.children:
        if (record.tag, child.tag) != ("TextBox", "Text"):
            _write_drawing(drawing_element, child)
