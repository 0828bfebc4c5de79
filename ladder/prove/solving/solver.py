"""Bitwuzla behind the few calls that proofs make, with limits that count steps.

The solver asks now and then whether to stop. It is deterministic, and so is the number of its questions: a
limit on them gives the same verdict on every machine.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import cache
from importlib.util import find_spec
from typing import Any

from ..algebra.meaning import BOOL, F32, INT
from ..algebra.terms import T
from .smtlib import pattern_of
from .translation import FIELDS, Sort, signed, width

STEPS = 20_000
"""Default limit of a question: how often the solver asks whether to stop. Some seconds of hard work."""

SAT, UNSAT, UNKNOWN = "sat", "unsat", "unknown"


class SolverMissingError(Exception):
    """Bitwuzla is not installed."""

    def __init__(self) -> None:
        super().__init__("proofs need bitwuzla: pip install 'scanrack[prove]'")


def is_installed() -> bool:
    """Whether bitwuzla is there; it is not loaded."""
    return find_spec("bitwuzla") is not None


@cache
def library() -> Any:
    """Return the module bitwuzla; a SolverMissingError without it."""
    try:
        import bitwuzla
    except ImportError:
        raise SolverMissingError from None
    return bitwuzla


@cache
def _kinds() -> dict[str, Any]:
    kind = library().Kind
    return {name: getattr(kind, member) for name, member in _MEMBERS.items()}


_MEMBERS = {
    "not": "NOT",
    "and": "AND",
    "or": "OR",
    "=": "EQUAL",
    "ite": "ITE",
    "bvslt": "BV_SLT",
    "bvsle": "BV_SLE",
    "bvadd": "BV_ADD",
    "bvsub": "BV_SUB",
    "bvmul": "BV_MUL",
    "bvsdiv": "BV_SDIV",
    "bvsrem": "BV_SREM",
    "bvand": "BV_AND",
    "bvor": "BV_OR",
    "bvxor": "BV_XOR",
    "extract": "BV_EXTRACT",
    "sign_extend": "BV_SIGN_EXTEND",
    "zero_extend": "BV_ZERO_EXTEND",
    "fp.add": "FP_ADD",
    "fp.sub": "FP_SUB",
    "fp.mul": "FP_MUL",
    "fp.div": "FP_DIV",
    "fp.neg": "FP_NEG",
    "fp.abs": "FP_ABS",
    "fp.sqrt": "FP_SQRT",
    "fp.rem": "FP_REM",
    "fp.eq": "FP_EQUAL",
    "fp.lt": "FP_LT",
    "fp.leq": "FP_LEQ",
    "fp.isNaN": "FP_IS_NAN",
    "fp.isInfinite": "FP_IS_INF",
    "fp.to_sbv": "FP_TO_SBV",
    "to_fp": "FP_TO_FP_FROM_FP",
    "to_fp_signed": "FP_TO_FP_FROM_SBV",
}


class Solver:
    """One session: variables and assertions stay, each question adds its own for a moment.

    Args:
        steps: limit of each question.
    """

    def __init__(self, steps: int = STEPS) -> None:
        module = library()
        self._manager = module.TermManager()
        options = module.Options()
        options.set(module.Option.PRODUCE_MODELS, True)
        self._solver = module.Bitwuzla(self._manager, options)
        self._solver.configure_terminator(self._tired)
        self._steps, self._left, self.spent = steps, 0, 0
        self._answers = {module.Result.SAT: SAT, module.Result.UNSAT: UNSAT}
        self._kinds = _kinds()
        modes = module.RoundingMode
        self._modes = {name: self._manager.mk_rm_value(getattr(modes, name)) for name in ("RNE", "RTZ")}
        self._bool_sort = self._manager.mk_bool_sort()
        self._sorts: dict[Sort, Any] = {}
        self._values: dict[tuple[Sort, Any], Any] = {}

    def _tired(self) -> bool:
        self._left -= 1
        self.spent += 1
        return self._left < 0

    def _sort(self, sort: Sort) -> Any:
        known = self._sorts.get(sort)
        if known is None:
            make = self._manager
            if sort == BOOL:
                known = self._bool_sort
            else:
                known = make.mk_bv_sort(sort) if isinstance(sort, int) else make.mk_fp_sort(*FIELDS[sort])
            self._sorts[sort] = known
        return known

    def declare(self, sort: Sort, name: str) -> Any:
        """Return a new variable."""
        return self._manager.mk_const(self._sort(sort), name)

    def value(self, sort: Sort, value: Any) -> Any:
        """Return a constant; that of a bit vector is its signed value."""
        if sort == BOOL:
            return self._manager.mk_true() if value else self._manager.mk_false()
        key = sort, value if isinstance(sort, int) else pattern_of(value, sort)
        known = self._values.get(key)
        if known is None:
            known = self._values[key] = self._literal(*key)
        return known

    def _literal(self, sort: Sort, value: Any) -> Any:
        make = self._manager
        if isinstance(sort, int):
            return make.mk_bv_value(self._sort(sort), str(value & (1 << sort) - 1), 10)
        pattern = make.mk_bv_value(make.mk_bv_sort(len(value)), value, 2)
        return make.mk_term(library().Kind.FP_TO_FP_FROM_BV, [pattern], list(FIELDS[sort]))

    def apply(self, op: str, args: Sequence[Any], indices: Sequence[int] = ()) -> Any:
        """Return an operation by its name in SMT-LIB; a rounding mode is given by its name."""
        operands = [self._modes[each] if isinstance(each, str) else each for each in args]
        return self._manager.mk_term(self._kinds[op], operands, list(indices))

    def state(self, formula: Any) -> None:
        """Assert a truth for good."""
        self._solver.assert_formula(formula)

    def check(self, *formulas: Any) -> str:
        """Ask whether all assertions and these truths can hold: sat, unsat, or unknown beyond the limit."""
        self._left = self._steps
        return self._answers.get(self._solver.check_sat(*formulas), UNKNOWN)

    def found(self, made: Any, t: T) -> Any:
        """Return the value of a term after sat; `t` says of which kind it is."""
        value = self._solver.get_value(made)
        if t.kind == BOOL:
            return bool(value.value())
        if t.kind == INT:
            return signed(int(value.value(10)), width(t))
        return _float(value, t.kind)


def _float(value: Any, kind: str) -> float:
    digits = value.value(2)
    digits = digits if isinstance(digits, str) else "".join(digits)
    packed = int(digits, 2).to_bytes(4 if kind == F32 else 8)
    return float(struct.unpack(">f" if kind == F32 else ">d", packed)[0])
