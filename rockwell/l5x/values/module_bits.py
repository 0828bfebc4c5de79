"""BOOLs of module-defined types, which are bits of the preceding integer, although no file shows this.

| BOOLs after an integer | bits |
|---|---|
| as many as it has bits | all, in order |
| numbered from 0 on: `Ch0Status`, `Ch1Status` | their numbers |
| numbered with gaps at their ends: `Ch0Range_8`, `Ch0Range_9` | their numbers |
| others, and BOOLs with values that differ from the integer's bits | their own memory |
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from scanrack.ladder.model.types import BOOL, Elementary, Member

from .value_texts import ValueTextError, value_of

FAULT = "FAULT"
"""Name, in capitals, of an integer in every input tag; it never contains the BOOLs after it."""

_NUMBER = re.compile(r"\d{1,2}")
_AT_END = re.compile(r"_(\d{1,2})\Z")


def with_bit_places(members: Iterable[Member], values: Mapping[str, str]) -> tuple[list[Member], list[str]]:
    """Return the members of a module's type with the places of bits, and the integers with unknown bits.

    Args:
        values: the texts of single values by name.
    """
    hosted: list[Member] = []
    unknown: list[str] = []
    for host, run in _runs(members):
        if host is not None:
            hosted.append(host)
        if not run or host is None or not _is_host(host):
            hosted += run
            continue
        bits = _bits_of(host, run, values)
        hosted += (replace(member, at=bits.get(member.name, "")) for member in run)
        if len(bits) < len(run):
            unknown.append(host.name)
    return hosted, unknown


def _runs(members: Iterable[Member]) -> Iterator[tuple[Member | None, list[Member]]]:
    """Yield each member that is not a single BOOL, with the single BOOLs that follow it."""
    host: Member | None = None
    run: list[Member] = []
    for member in members:
        if member.type is BOOL and not member.dims:
            run.append(member)
            continue
        if host is not None or run:
            yield host, run
        host, run = member, []
    yield host, run


def _is_host(member: Member) -> bool:
    """Return whether a member may contain the BOOLs after it."""
    integer = isinstance(member.type, Elementary) and member.type.is_integer and not member.dims
    return integer and member.name.upper() != FAULT


def _bits_of(host: Member, run: Sequence[Member], values: Mapping[str, str]) -> dict[str, str]:
    """Return the places of BOOLs in a host, such as `Data.3`, by name; {} if a value differs from its bit."""
    assert isinstance(host.type, Elementary)
    numbers = _numbers([member.name for member in run], host.type.bits)
    try:
        word = int(value_of(values.get(host.name, "0"), host.type))
        for name, bit in numbers.items():
            if bool(word >> bit & 1) != value_of(values.get(name, "0"), BOOL):
                return {}
    except ValueTextError:
        return {}
    return {name: f"{host.name}.{bit}" for name, bit in numbers.items()}


def _numbers(names: Sequence[str], bits: int) -> dict[str, int]:
    """Return the bit number of each name, except unknown numbers.

    Args:
        bits: number of bits of the host.
    """
    if len(names) == bits or (len(names) > 1 and _is_series(names)):
        return {name: bit for bit, name in enumerate(names)}
    ends = [(name, _AT_END.search(name)) for name in names]
    numbers = {name: int(end[1]) for name, end in ends if end}
    ordered = list(numbers.values())
    has_gaps = bool(ordered) and len(ordered) <= ordered[-1] < bits
    return numbers if has_gaps and ordered == sorted(set(ordered)) else {}


def _is_series(names: Sequence[str]) -> bool:
    """Return whether names differ only in their first number, and the numbers count up from 0."""
    matches = [_NUMBER.search(name) for name in names]
    numbers = [int(match[0]) for match in matches if match]
    patterns = {_NUMBER.sub("#", name, count=1) for name in names}
    return numbers == list(range(len(names))) and len(patterns) == 1
