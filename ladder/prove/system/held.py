"""Numbers and bits that nothing writes and that are not free; proofs assume that they keep their values.

If only some bits of a number are written, the other bits keep their values. A proof depends on the constant
bits that the program reads:

    XIC(Mode.1)  EQU(Mode,12)  OTE(Mode.4)      bits 0, 2, 3 and 5 to 31 of Mode; bit 1 is free
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from ..algebra.meaning import INT
from ..algebra.terms import T, bits_of, reach
from ..relation.places import Key
from .transition import HeldNumber, System

MOST_BITS = 8
"""Maximum number of bits that are listed separately; with more, the whole number is listed."""


def held_numbers(
    system: System, cone: Iterable[str], roots: Sequence[T], written: Mapping[str, int]
) -> Iterator[HeldNumber]:
    """Yield the numbers and bits that terms and their cone read and that nothing writes, in name order.

    Args:
        written: masks of the written bits, for states of which only some bits are written.
    """
    names = sorted(cone)
    bits = held_bits(system, names, roots, written)
    for name in names:
        key = system.key_of.get(name)
        if key is None or name.startswith("~"):
            continue
        if name in system.held:
            yield HeldNumber(key, None, system.initial[name])
        elif name in bits:
            yield from _of_bits(key, int(system.initial[name]), bits[name])


def held_bits(
    system: System, names: Iterable[str], roots: Sequence[T], written: Mapping[str, int]
) -> dict[str, int]:
    """Return masks of the bits that are read and not written, in numbers whose other bits are written."""
    states = [name for name in names if name in system.next]
    partly_written = [name for name in states if name in written]
    other_terms = [system.next[name] for name in states if name not in written]
    read = read_bits([*other_terms, *roots], [system.next[name] for name in partly_written])
    return {name: mask for name in partly_written if (mask := read.get(name, 0) & ~written[name])}


def _of_bits(key: Key, value: int, mask: int) -> Iterator[HeldNumber]:
    """Yield the held bits of a number, or the number itself if there are many."""
    if mask.bit_count() > MOST_BITS:
        yield HeldNumber(key, None, value)
        return
    for number in range(mask.bit_length()):
        if mask >> number & 1:
            yield HeldNumber(key, number, value >> number & 1)


def read_bits(roots: Sequence[T], kept: Sequence[T]) -> dict[str, int]:
    """Return masks of the bits that terms read, by the name of the variable.

    Args:
        kept: next values of numbers with constant bits; keeping a bit does not count as reading it.
    """
    needed: dict[int, int] = {}
    all_roots = [*roots, *kept]
    for term in roots:
        needed[term.id] = _every(term)
    masks: dict[str, int] = {}
    for term in reversed(reach(all_roots)):
        mask = needed.get(term.id, 0)
        if term.op == "var" and mask:
            masks[term.val] = mask
        for operand, operand_mask in zip(term.args, _operand_masks(term, mask), strict=True):
            needed[operand.id] = needed.get(operand.id, 0) | operand_mask
    return masks


def _every(t: T) -> int:
    """Return the mask of all bits of a term."""
    return (1 << bits_of(t.lo, t.hi)) - 1 if t.kind == INT else 1


def _operand_masks(t: T, needed_bits: int) -> tuple[int, ...]:
    """Return a mask for each operand of a term: the bits that the needed bits of the term depend on."""
    if t.op == "setbit":
        return needed_bits & ~(1 << t.val[0]), 1
    if t.op == "ite":
        return 1, needed_bits, needed_bits
    if t.op == "bit":
        return (1 << t.val if needed_bits else 0,)
    return tuple(_every(operand) if needed_bits else 0 for operand in t.args)
