r"""Names of a program's tags, in all notations.

    Run, Fill.ACC              a tag of the controller, a member
    \Main.Step                 a tag of a program; `Program:Main.Step` is the same
    Step                       the same, if neither the controller nor any other program has a Step
    Ps[1].Count, Grid[1,2]     an element; B[34] of a list
    Word.3                     a bit
    N7:3, T4:0.ACC, T4:0/DN    an element of an SLC data file, or a member or bit of the element
    B3:1/4, B3/20              a bit of a file; the second form numbers bits from the file's beginning

Case does not matter. A recorded array has one name for all of its elements: `B`, or `Ps[0..2].Count` if
the subscript is not at the end, or is not the only one.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache

TEXT = "TEXT"
"""Type of a recorded tag that is text."""

_FILE_BITS = 16
_PROGRAM = re.compile(r"^Program:(\w+)\.", re.IGNORECASE)
_BASE = re.compile(r"(\\\w+\.)?(\w+)", re.ASCII)
_FILE_BIT = re.compile(r"(?P<file>[A-Za-z]{1,2}\d{0,3})/(?P<bit>\d{1,6})", re.ASCII)
_STEP = re.compile(
    r"""\s*\[\s*(?P<quote>'[^']*'|"[^"]*")\s*\]|\s*\[(?P<index>[^\[\]]*)\]|:(?P<element>\d+)"""
    r"""|/(?P<bit>\w+)|\.(?P<name>\w+)"""
)
_PART_END = re.compile(r"[.\[]")
_RANGE = re.compile(r"(\d+)\.\.(\d+)")
_RANGES = re.compile(r"\[\d+\.\.\d+(?:,\d+\.\.\d+)*+\]|:\d+\.\.\d+")


class AmbiguousNameError(ValueError):
    """Several programs declare the name."""


def normal(text: str) -> str:
    r"""Return a name as rungs write it: a program with a backslash, and a file's bit by its element.

    >>> print(normal("Program:Main.Step"), normal("B3/20"), normal(r"\Main.Step"))
    \Main.Step B3:1/4 \Main.Step
    """
    text = _PROGRAM.sub(r"\\\1.", text.strip(), count=1)
    bit = _FILE_BIT.fullmatch(text)
    if bit is None:
        return text
    element, file_bit = divmod(int(bit["bit"]), _FILE_BITS)
    return f"{bit['file']}:{element}/{file_bit}"


@lru_cache(maxsize=65_536)
def key_of(text: str) -> str | None:
    r"""Return the canonical form of a name; None if it is not a tag name.

    >>> key_of(r"\Main.Ps[ 1 ].Count"), key_of("Program:Main.Ps[1].COUNT"), key_of("N7:3"), key_of("N7[3]")
    ('\\main.ps[1].count', '\\main.ps[1].count', 'n7[3]', 'n7[3]')
    >>> key_of("B3/20"), key_of("B3:1/4"), key_of("T4:0/DN"), key_of("a + b")
    ('b3[1].4', 'b3[1].4', 't4[0].dn', None)
    """
    text = normal(text)
    base = _BASE.match(text)
    if base is None:
        return None
    parts, offset = [base.group().lower()], base.end()
    while offset < len(text):
        step = _STEP.match(text, offset)
        if step is None:
            return None
        parts.append(_key_of_step(step))
        offset = step.end()
    return "".join(parts)


def _key_of_step(step: re.Match[str]) -> str:
    """Return the canonical form of a step after a base name: `[1,2]`, `['key']`, `.4` or `.acc`."""
    if step["quote"] is not None:
        return f"[{step['quote'][1:-1]!r}]"
    if step["index"] is not None:
        return f"[{','.join(index.strip().lower() for index in step['index'].split(','))}]"
    if step["element"] is not None:
        return f"[{step['element']}]"
    return f".{(step['bit'] or step['name']).lower()}"


def in_scope(text: str, known: Iterable[str]) -> str:
    r"""Return a name with its program, adding the program if it is missing.

    >>> in_scope("Step.3", ["Run", r"\Main.Step"]), in_scope("Run", ["Run", r"\Main.Run"])
    ('\\Main.Step.3', 'Run')

    Args:
        known: all tag names, with their programs.

    Raises:
        AmbiguousNameError: several programs have a tag of that name.
    """
    text = normal(text)
    base = _BASE.match(text)
    if base is None or base[1]:
        return text
    lowered = base[2].lower()
    owners: dict[str, str] = {}
    for name in known:
        scope, _, base_name = name.rpartition(".") if name.startswith("\\") else ("", "", name)
        if base_name.lower() == lowered:
            owners.setdefault(name.lower(), name)
            if not scope:
                return text
    if len(owners) > 1:
        raise AmbiguousNameError(f"{base[2]} is ambiguous: it is {' or '.join(owners.values())}")
    return next(iter(owners.values()), base[2]) + text[base.end() :]


def base_of(name: str) -> str:
    r"""Return the tag in a name: `\Main.Fill` in `\Main.Fill.ACC`."""
    match = _BASE.match(name)
    return match.group() if match else name


def without_ranges(name: str) -> str:
    """Return the name of an array without its subscripts.

    >>> without_ranges("Ps[0..2].Count"), without_ranges("N7:0..9"), without_ranges("Recipe[3].T")
    ('Ps.Count', 'N7', 'Recipe[3].T')
    """
    return _RANGES.sub("", name) if ".." in name else name


def element_of(name: str, index: int) -> str:
    """Return the name of an element of an array.

    >>> element_of("B", 34), element_of("Ps[0..2].Count", 1), element_of("Grid[0..1,0..2]", 5)
    ('B[34]', 'Ps[1].Count', 'Grid[1,2]')
    >>> element_of("T4:0..9.ACC", 7)
    'T4:7.ACC'

    Args:
        name: recorded name of the array.
        index: index of the element, counted over all dimensions.
    """
    ranges = [(int(begin), int(end)) for begin, end in _RANGE.findall(name)]
    if not ranges:
        return f"{name}[{index}]"
    subscripts = []
    for first_index, last_index in reversed(ranges):
        index, offset = divmod(index, last_index - first_index + 1)
        subscripts.append(str(first_index + offset))
    return _RANGE.sub(lambda _: subscripts.pop(), name)


class NamesByPattern:
    """Finds names by patterns with `*` and `?`, which match a name or its part before a dot or subscript.

    >>> names = NamesByPattern(["Fill.ACC", "Fill.PRE", "Level"])
    >>> names.indexes("Fill"), names.indexes("Fi"), names.indexes("*.acc"), names.indexes("*el")
    ([0, 1], [], [], [2])
    >>> NamesByPattern(["Fill.ACC"], fold=True).indexes("fill.acc")
    [0]

    Args:
        fold: whether case is ignored.
    """

    def __init__(self, names: Iterable[str], *, fold: bool = False) -> None:
        self._fold = str.lower if fold else str
        self._names = [self._fold(name) for name in names]
        self._by_part: dict[str, list[int]] = {}  # indexes by whole name, and by each part that can match
        for index, name in enumerate(self._names):
            for end in (*(part.start() for part in _PART_END.finditer(name)), len(name)):
                self._by_part.setdefault(name[:end], []).append(index)

    def indexes(self, pattern: str) -> list[int]:
        """Return the indexes of the names that match, in order."""
        pattern = self._fold(pattern)
        if not {"*", "?"} & set(pattern):
            return self._by_part.get(pattern, [])
        text = "".join({"*": ".*", "?": "."}.get(character, re.escape(character)) for character in pattern)
        matches = re.compile(rf"{text}(?:[.\[]|$)").match
        return [index for index, name in enumerate(self._names) if matches(name)]
