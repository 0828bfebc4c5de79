"""The structured text of each type of block, with its pins in braces.

A block has a tag, and its pins are members of the tag. A function of a 5380 or 5580 controller has no tag, so
its output is a generated tag. Blocks that are also instructions of structured text are called [1756-RM003,
1756-RM006, the page of each instruction, function block].
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from scanrack.ladder.instructions import BY_NAME
from scanrack.ladder.model.operators import COMPARISONS
from scanrack.ladder.model.predefined.block_types import BLOCK_STRUCTURES, DIAGRAM_TYPES
from scanrack.ladder.model.predefined.process_types import ARRAYS
from scanrack.ladder.model.types import Structure


@dataclass(frozen=True, slots=True)
class BlockForm:
    """The structure and the structured text of a type of block."""

    structure: Structure
    lines: tuple[str, ...]
    output: str = ""  # the pin that the lines compute; "" for an instruction of structured text
    formula: str = ""  # the value of the output as an expression; "" if there is no single expression
    arrays: tuple[str, ...] = ()  # array operands after the tag; the last ones may be omitted


def _formula(structure: str, output: str, formula: str) -> BlockForm:
    return BlockForm(DIAGRAM_TYPES[structure], (f"{{{output}}} := {formula};",), output, formula)


def _of_two_sources(structure: str, operator: str) -> BlockForm:
    return _formula(structure, "Dest", f"{{SourceA}} {operator} {{SourceB}}")


def _eight_inputs(operator: str) -> str:
    return f" {operator} ".join(f"{{In{number}}}" for number in range(1, 9))


_LIMITS = (
    "({LowLimit} <= {HighLimit} AND {Test} >= {LowLimit} AND {Test} <= {HighLimit}) OR "
    "({LowLimit} > {HighLimit} AND ({Test} >= {LowLimit} OR {Test} <= {HighLimit}))"
)

_MUX = BlockForm(
    DIAGRAM_TYPES["MULTIPLEXER"],
    (
        "CASE {Selector} OF",
        *(f"{number}: {{Out}} := {{In{number}}};" for number in range(1, 9)),
        "END_CASE;",
        "{InstructFault} := {Selector} < 1 OR {Selector} > 8;",
        "{SelectorInv} := {InstructFault};",
        "IF {SelectorInv} THEN {Status} := 3; ELSE {Status} := 0; END_IF;",
    ),
    "Out",
)
"""A Selector outside 1 to 8 keeps Out, and sets InstructFault (Status.0) and SelectorInv (Status.1)."""

FORMULAS: Mapping[str, BlockForm] = {
    "BAND": _formula("FBD_BOOLEAN_AND", "Out", _eight_inputs("AND")),
    "BOR": _formula("FBD_BOOLEAN_OR", "Out", _eight_inputs("OR")),
    "BXOR": _formula("FBD_BOOLEAN_XOR", "Out", "{In1} XOR {In2}"),
    "BNOT": _formula("FBD_BOOLEAN_NOT", "Out", "NOT {In}"),
    **{
        name: _of_two_sources("FBD_MATH", operator)
        for name, operator in (
            ("ADD", "+"),
            ("SUB", "-"),
            ("MUL", "*"),
            ("DIV", "/"),
            ("MOD", "MOD"),
            ("XPY", "**"),
        )
    },
    **{
        name: _formula("FBD_MATH_ADVANCED", "Dest", f"{name}({{Source}})")
        for name in ("SQR", "ABS", "SIN", "COS", "TAN", "ASN", "ACS", "ATN", "LN", "LOG", "DEG", "RAD")
    },
    "NEG": _formula("FBD_MATH_ADVANCED", "Dest", "-{Source}"),
    "TRN": _formula("FBD_TRUNCATE", "Dest", "TRN({Source})"),
    "TOD": _formula("FBD_CONVERT", "Dest", "TOD({Source})"),
    "FRD": _formula("FBD_CONVERT", "Dest", "FRD({Source})"),
    **{name: _of_two_sources("FBD_COMPARE", operator) for name, operator in COMPARISONS.items()},
    "LIM": _formula("FBD_LIMIT", "Dest", _LIMITS),
    "MEQ": _formula("FBD_MASK_EQUAL", "Dest", "({Source} AND {Mask}) = ({Compare} AND {Mask})"),
    "AND": _of_two_sources("FBD_LOGICAL", "AND"),
    "OR": _of_two_sources("FBD_LOGICAL", "OR"),
    "XOR": _of_two_sources("FBD_LOGICAL", "XOR"),
    "NOT": _formula("FBD_LOGICAL", "Dest", "NOT {SourceA}"),
    "MVMT": _formula("FBD_MASKED_MOVE", "Dest", "({Source} AND {Mask}) OR ({Target} AND NOT {Mask})"),
}
"""Blocks, and functions with the same names, that compute a formula."""

BLOCKS: Mapping[str, BlockForm] = {
    **FORMULAS,
    "MUX": _MUX,
    **{
        name: BlockForm(structure, (f"{name}({{}});",), arrays=ARRAYS.get(name, ()))
        for name, structure in BLOCK_STRUCTURES.items()
    },
}
"""Blocks by type."""

FUNCTION = "__F"
"""Suffix of a function's type, as in `ADD__F`."""


def canonical(name: str) -> str:
    """Return the name of a block or function in `BLOCKS`; other revisions may use another name.

    >>> canonical("SQRT__F"), canonical("add")
    ('SQR', 'ADD')
    """
    stem = name.upper().removesuffix(FUNCTION)
    return BY_NAME[stem].name if stem in BY_NAME else stem
