"""The table `[server]` of a rack file: the tags that clients of `--server` see and may write."""

from __future__ import annotations

from typing import Annotated, Literal, TypeVar

from pydantic import Field

from .machine_tables import Table

WordOrder = Literal["high first", "low first"]
HIGH_FIRST: WordOrder = "high first"

Text = Annotated[str, Field(min_length=1, max_length=200)]
Item = TypeVar("Item")
Rows = Annotated[tuple[Item, ...], Field(strict=False, max_length=20_000)]


class MapRow(Table):
    """A tag that is mapped to coils or registers.

    Attributes:
        address: address of its first coil or register, from 0.
        tag: name of the tag; an array also occupies the following addresses.
        order: first word of a DINT, REAL, LINT or LREAL; the table's `order` if omitted.
    """

    address: Annotated[int, Field(ge=0, le=0xFFFF)]
    tag: Text
    order: WordOrder | None = None


class ModbusTable(Table):
    """The tags that `--server modbus-tcp` maps to coils and registers.

    Attributes:
        order: first word of a DINT, REAL, LINT or LREAL.
        fill: whether an address without a tag, lower than the last address in its table, reads as 0; if
            false, the server refuses it.
        coils: bits that clients read and write.
        discrete_inputs: bits that clients read.
        input_registers: numbers that clients read.
        holding_registers: numbers that clients read and write.
    """

    order: WordOrder = HIGH_FIRST
    fill: bool = False
    coils: Rows[MapRow] = ()
    discrete_inputs: Rows[MapRow] = ()
    input_registers: Rows[MapRow] = ()
    holding_registers: Rows[MapRow] = ()


class ServerTable(Table):
    """The tags that clients of a tag server see and may write.

    Attributes:
        writable: patterns of tags that clients may write, with all their members: "Run", "Recipe.*",
            "Local:1:O.Data", "Program:Main.*"; without patterns, clients can only read.
        profile: names of the parts of `Local:n:I`: "generic" (Fault, Data) or "3601" (Data0, ModuleOK, ...).
        modbus: tags as coils and registers; without this table `--server modbus-tcp` is refused.
    """

    writable: Rows[Text] = ()
    profile: Literal["generic", "3601"] = "generic"
    modbus: ModbusTable | None = None
