"""The table `[server]` of a rack file: what clients of `--server` see and may write."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from .machine_tables import Table


class ServerTable(Table):
    """What clients of a tag server see and may write.

    Attributes:
        writable: patterns of tags that clients may write, with all below each: "Run", "Recipe.*",
            "Local:1:O.Data", "Program:Main.*"; without them clients only read.
        profile: names of the parts of `Local:n:I`: "generic" (Fault, Data) or "3601" (Data0, ModuleOK, ...).
    """

    writable: Annotated[
        tuple[Annotated[str, Field(min_length=1, max_length=200)], ...], Field(strict=False)
    ] = ()
    profile: Literal["generic", "3601"] = "generic"
