"""The arguments of `scanrack why`, without typer."""

from __future__ import annotations

from scanrack.io_images.dataclass import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class WhyArguments:
    """The arguments and the options of `scanrack why`; `why` describes them."""

    file: str
    what: str | None = None
    at: str | None = None
    until: str | None = None
    deep: bool = False
    want: str | None = None
    trust: bool = False
    as_json: bool = False
