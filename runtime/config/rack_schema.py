"""Generates the JSON Schema of rack files, for editors.

Types and limits come from the tables' validators, descriptions come from their docstrings, and modules and
their options come from the registry. The schema can't detect conflicts between two keys, but `scanrack check`
can.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from decimal import Decimal
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from ..modules.registry import OWN
from .machine_tables import TABLE, Table
from .rackspec import RackSpec, SlotSpec

NAME = "rack.schema.json"
"""Name of the schema file, as given in the first line of a rack file."""

HINT = f"#:schema {NAME}"
"""The first line of a rack file; tombi and taplo read it to find the schema."""

TITLE = "scanrack rack file"
"""Title of the schema, which identifies its file."""

DRAFT_2020, DRAFT_4 = (
    "https://json-schema.org/draft/2020-12/schema",
    "http://json-schema.org/draft-04/schema#",
)

_ATTRIBUTE = re.compile(r"^ {4}(\w+): (.*(?:\n {8}.*)*+)", re.MULTILINE)
"""Matches a key and its description in the "Attributes" section of a docstring."""

_OTHER_UNIT = {"ms": "s", "s": "ms"}


def rack_schema(*, draft4: bool = False) -> dict[str, Any]:
    """Return the schema of rack files.

    Args:
        draft4: return JSON Schema Draft 4, which taplo reads, instead of Draft 2020-12.
    """
    schema = RackSpec.model_json_schema(schema_generator=_Generator)
    _add_options(schema)
    document = {"$schema": DRAFT_2020, "title": TITLE, **_without_null(schema)}
    return _as_draft4(document, top=True) if draft4 else document


def described_keys(cls: type) -> dict[str, str]:
    """Return the description of each key of a table, from the docstrings of its class and base classes.

    >>> described_keys(SlotSpec)["number"]
    'slot number, from 1.'
    """
    meanings: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        docstring = inspect.cleandoc(base.__dict__.get("__doc__") or "")
        _, _, attributes = docstring.partition("\nAttributes:\n")
        for key, meaning in _ATTRIBUTE.findall(attributes):
            meanings[key] = re.sub(r"\s+", " ", meaning)
    # a docstring explains only one key of a time, such as at_ms of at_ms and at_s
    for key in getattr(cls, "model_fields", ()):
        name, _, unit = key.rpartition("_")
        other_key = f"{name}_{_OTHER_UNIT.get(unit)}"
        if key not in meanings and other_key in meanings:
            meaning = meanings[other_key].replace(f"`{key}`", f"`{other_key}`")
            meanings[key] = meaning.replace(", ms", f", {unit}")
    return meanings


class _Generator(GenerateJsonSchema):
    """Generates schemas: descriptions of tables from their docstrings, and numbers as TOML types."""

    def model_schema(self, schema: core_schema.ModelSchema) -> JsonSchemaValue:
        """Describe a table."""
        return _described(super().model_schema(schema), schema["cls"])

    def dataclass_schema(self, schema: core_schema.DataclassSchema) -> JsonSchemaValue:
        """Describe a part of a machine."""
        return _described(super().dataclass_schema(schema), schema["cls"])

    def function_plain_schema(self, schema: core_schema.PlainValidatorFunctionSchema) -> JsonSchemaValue:
        """Describe a `Rare` table."""
        table: type[Table] | None = schema.get("metadata", {}).get(TABLE)
        if table is None:
            return super().function_plain_schema(schema)
        table.model_rebuild()
        table_schema: Any = table.__pydantic_core_schema__
        if table_schema["type"] == "definitions":
            named_schema = {**table_schema["schema"], "ref": table.__name__}
            return self.generate_inner({**table_schema, "schema": named_schema})
        return self.generate_inner({**table_schema, "ref": table.__name__})

    def decimal_schema(self, schema: core_schema.DecimalSchema) -> JsonSchemaValue:
        """Describe a number of any type."""
        limits: JsonSchemaValue = {}
        self.update_with_validations(limits, schema, self.ValidationsMapping.numeric)
        return {"type": "number", **{key: float(value) for key, value in limits.items()}}

    def encode_default(self, dft: Any) -> Any:
        """Return a default as a TOML value, or None if the default is a table."""
        if isinstance(dft, Decimal):
            return int(dft) if dft == int(dft) else float(dft)
        return dft if isinstance(dft, bool | int | float | str) else None

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        """Omit defaults that are tables or None."""
        described = super().default_schema(schema)
        if "default" in described and described["default"] is None:
            del described["default"]
        return described


def _described(node: JsonSchemaValue, cls: type) -> JsonSchemaValue:
    """Add a class's docstring to its schema, and rename the limits of its keys; return the schema."""
    keys = described_keys(cls)
    node["description"] = inspect.cleandoc(cls.__doc__ or "").partition("\n\n")[0].replace("\n", " ")
    node.pop("title", None)
    for key, value in node.get("properties", {}).items():
        value.pop("title", None)
        if key in keys:
            value["description"] = keys[key]
        _rename_limits(value)
    return node


def _rename_limits(node: JsonSchemaValue) -> None:
    """Rename the limits of a validated number to the JSON Schema keywords."""
    for branch in (node, *node.get("anyOf", ())):
        branch.pop("decimal_places", None)
        for key, word in (("ge", "minimum"), ("gt", "exclusiveMinimum"), ("le", "maximum")):
            if key in branch:
                branch[word] = branch.pop(key)


def _add_options(schema: dict[str, Any]) -> None:
    """Add a branch to the slot table for each kind of module options."""
    definitions = schema["$defs"]
    slot = definitions[SlotSpec.__name__]
    modules_by_table: dict[type[BaseModel], list[str]] = {}
    for name, record in OWN.items():
        if record.option_table is not None:
            modules_by_table.setdefault(record.option_table(), []).append(name)
    own_modules = {"properties": {"slot": {"items": {"properties": {"module": {"enum": list(OWN)}}}}}}
    slot["properties"]["module"]["examples"] = list(OWN)
    # a file with [modules] may have other names
    schema["if"], schema["then"] = {"not": {"required": ["modules"]}}, own_modules
    for table in modules_by_table:
        table_schema = table.model_json_schema(schema_generator=_Generator)
        definitions.update(table_schema.pop("$defs", {}))
        definitions[table.__name__] = table_schema
    slot["anyOf"] = [
        {"properties": {"module": {"enum": names}, "options": {"$ref": f"#/$defs/{table.__name__}"}}}
        for table, names in modules_by_table.items()
    ]
    # accept every other name here, so that an editor shows one error for it and not one per branch
    slot["anyOf"].append({"properties": {"module": {"not": {"enum": list(OWN)}}}})


def _without_null(node: Any) -> Any:
    """Return a schema without null, which TOML does not have."""
    if isinstance(node, list):
        return [_without_null(element) for element in node]
    if not isinstance(node, dict):
        return node
    branches = [branch for branch in node.get("anyOf", ()) if branch != {"type": "null"}]
    if len(branches) == 1:
        node = {**branches[0], **{key: value for key, value in node.items() if key != "anyOf"}}
    return {key: _without_null(value) for key, value in node.items()}


def _each_as_draft4(schemas: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _as_draft4(schema) for name, schema in schemas.items()}


_DRAFT_4_KEYS: Mapping[str, Callable[[Any, Mapping[str, Any]], dict[str, Any]]] = {
    "properties": lambda value, _node: {"properties": _each_as_draft4(value)},
    "$defs": lambda value, _node: {"definitions": _each_as_draft4(value)},
    "prefixItems": lambda value, _node: {"items": _as_draft4(value), "additionalItems": False},
    "const": lambda value, _node: {"enum": [value]},
    "exclusiveMinimum": lambda value, _node: {"minimum": value, "exclusiveMinimum": True},
    "exclusiveMaximum": lambda value, _node: {"maximum": value, "exclusiveMaximum": True},
    "if": lambda _value, _node: {},
    "then": lambda value, node: {"anyOf": [{"not": _as_draft4(node["if"])}, _as_draft4(value)]},
    "examples": lambda _value, _node: {},
}
"""Functions that convert a key to Draft 4, given its value and schema; other keys stay the same."""


def _as_draft4(node: Any, *, top: bool = False) -> Any:
    """Convert a schema to Draft 4: references without siblings, flags for exclusive limits, no `if`."""
    if isinstance(node, list):
        return [_as_draft4(element) for element in node]
    if not isinstance(node, Mapping):
        return node
    draft4: dict[str, Any] = {}
    for key, value in node.items():
        convert = _DRAFT_4_KEYS.get(key)
        draft4 |= {key: _as_draft4(value)} if convert is None else convert(value, node)
    if top:
        draft4["$schema"] = DRAFT_4
    if "$ref" in draft4:
        reference = {"$ref": draft4.pop("$ref").replace("#/$defs/", "#/definitions/")}
        return {"allOf": [reference], **draft4} if draft4 else reference
    return draft4
