"""The interface of proofs to bitwuzla. It counts work independently of bitwuzla's version.

Work is the number of terms in each question. The solver's own steps are counted each time it polls whether to
stop. They are the same on every machine but not in every version. They serve only as a fuse, far above what
most questions need.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import cache
from importlib.util import find_spec
from typing import Any

from scanrack.io_images.installing import how_to_install
from scanrack.io_images.versions import distribution_version

from ...model.arithmetic import wrap
from ..algebra.meaning import BOOL, F32, INT
from ..algebra.terms import T
from .smtlib import pattern_of
from .translation import FIELDS, Sort, width

FUSE = 320_000
"""Default fuse for a question, in solver steps."""

SAT, UNSAT, UNKNOWN = "sat", "unsat", "unknown"


class SolverMissingError(Exception):
    """Raised if bitwuzla is not installed."""

    def __init__(self) -> None:
        super().__init__(f"proofs need bitwuzla: {how_to_install('prove')}")


def is_installed() -> bool:
    """Return whether bitwuzla is installed, without loading it."""
    return find_spec("bitwuzla") is not None


@cache
def bitwuzla_module() -> Any:
    """Return the module bitwuzla; raise a SolverMissingError if it is not installed."""
    try:
        import bitwuzla
    except ImportError:
        raise SolverMissingError from None
    return bitwuzla


def fuse_text() -> str:
    """Return text with the fuse and the solver's version, because another version may get further."""
    return f"the solver's fuse (bitwuzla {distribution_version('bitwuzla')})"


@cache
def _kinds() -> dict[str, Any]:
    """Return Bitwuzla's kinds of terms by SMT-LIB name."""
    kind = bitwuzla_module().Kind
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


class _Fuse:
    """Counts the solver's steps. It must not refer to the solver, because that cycle would never be freed."""

    __slots__ = ("left", "steps")

    def __init__(self) -> None:
        self.left = self.steps = 0

    def __call__(self) -> bool:
        self.left -= 1
        self.steps += 1
        return self.left < 0


class Solver:
    """One solver session. Variables and assertions persist; a question's formulas apply only to it.

    Its terms are numbers. Bitwuzla's objects stay private, so that they are deleted in order: up to 0.9.1,
    the process crashes with a segmentation fault if Python's garbage collector clears a term's manager before
    the term.

    Args:
        fuse: number of steps after which the solver gives up on a question.

    Attributes:
        made: number of terms created so far.
        work: total of the number of terms at each question.
    """

    def __init__(self, fuse: int = FUSE) -> None:
        module = bitwuzla_module()
        self._manager = module.TermManager()
        options = module.Options()
        options.set(module.Option.PRODUCE_MODELS, True)
        self._solver = module.Bitwuzla(self._manager, options)
        self._fuse = _Fuse()
        self._solver.configure_terminator(self._fuse)
        self._most, self.made, self.work = fuse, 0, 0
        self._answers = {module.Result.SAT: SAT, module.Result.UNSAT: UNSAT}
        self._kinds = _kinds()
        modes = module.RoundingMode
        self._modes = {name: self._manager.mk_rm_value(getattr(modes, name)) for name in ("RNE", "RTZ")}
        self._bool_sort = self._manager.mk_bool_sort()
        self._sorts: dict[Sort, Any] = {}
        self._values: dict[tuple[Sort, Any], int] = {}  # numbers of constants
        self._terms: list[Any] = []  # by number

    def __del__(self) -> None:
        """Delete Bitwuzla's objects, the manager last."""
        for name in ("_terms", "_modes", "_sorts", "_bool_sort", "_solver", "_manager"):
            self.__dict__.pop(name, None)  # empty if bitwuzla is not installed

    @property
    def steps(self) -> int:
        """Number of solver steps so far."""
        return self._fuse.steps

    def _sort(self, sort: Sort) -> Any:
        """Return Bitwuzla's object for a sort; create it only once."""
        sort_term = self._sorts.get(sort)
        if sort_term is None:
            manager = self._manager
            if sort == BOOL:
                sort_term = self._bool_sort
            else:
                sort_term = (
                    manager.mk_bv_sort(sort) if isinstance(sort, int) else manager.mk_fp_sort(*FIELDS[sort])
                )
            self._sorts[sort] = sort_term
        return sort_term

    def _number(self, term: Any) -> int:
        """Store one of Bitwuzla's terms; return its number."""
        self._terms.append(term)
        return len(self._terms) - 1

    def declare(self, sort: Sort, name: str) -> int:
        """Return a new variable."""
        return self._number(self._manager.mk_const(self._sort(sort), name))

    def value(self, sort: Sort, value: Any) -> int:
        """Return a constant; for a bit vector, `value` is its signed value."""
        plain = sort == BOOL or isinstance(sort, int)
        key = sort, value if plain else pattern_of(value, sort)
        number = self._values.get(key)
        if number is None:
            number = self._values[key] = self._number(self._literal(*key))
        return number

    def _literal(self, sort: Sort, value: Any) -> Any:
        """Return a new constant of Bitwuzla; a float is passed as its bits in digits."""
        manager = self._manager
        if sort == BOOL:
            return manager.mk_true() if value else manager.mk_false()
        if isinstance(sort, int):
            return manager.mk_bv_value(self._sort(sort), str(value & (1 << sort) - 1), 10)
        pattern = manager.mk_bv_value(manager.mk_bv_sort(len(value)), value, 2)
        return manager.mk_term(bitwuzla_module().Kind.FP_TO_FP_FROM_BV, [pattern], list(FIELDS[sort]))

    def apply(self, op: str, args: Sequence[Any], indices: Sequence[int] = ()) -> int:
        """Return the result of an operation, given its SMT-LIB name; a rounding mode is also a name."""
        self.made += 1
        operands = [
            self._modes[argument] if isinstance(argument, str) else self._terms[argument] for argument in args
        ]
        return self._number(self._manager.mk_term(self._kinds[op], operands, list(indices)))

    def joined(self, op: str, conditions: Sequence[int]) -> int:
        """Return the conjunction (`and`) or disjunction (`or`) of one or more conditions."""
        return self.apply(op, conditions) if len(conditions) > 1 else conditions[0]

    def state(self, formula: int) -> None:
        """Assert a condition permanently."""
        self._solver.assert_formula(self._terms[formula])

    def check(self, *formulas: int) -> str:
        """Return whether all assertions and formulas can be true: sat, unsat, or unknown for a blown fuse."""
        self.work += 1 + self.made
        self._fuse.left = self._most
        return self._answers.get(
            self._solver.check_sat(*[self._terms[formula] for formula in formulas]), UNKNOWN
        )

    def found(self, number: int, t: T) -> Any:
        """Return the value that the solver chose for a term, after sat; `t` determines its kind."""
        value = self._solver.get_value(self._terms[number])
        if t.kind == BOOL:
            return bool(value.value())
        if t.kind == INT:
            return wrap(int(value.value(10)), width(t))
        return _float(value, t.kind)


def _float(value: Any, kind: str) -> float:
    """Return the float that the solver chose."""
    digits = value.value(2)
    digits = digits if isinstance(digits, str) else "".join(digits)
    packed = int(digits, 2).to_bytes(4 if kind == F32 else 8)
    return float(struct.unpack(">f" if kind == F32 else ">d", packed)[0])
