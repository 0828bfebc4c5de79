"""The compiler: one Python function per routine.

Memory cells become local variables of the function, so that a tag is as fast as a variable. The compiler
determines addresses, widths, ranges, and the conversions that can overflow. The rung condition is a Python
expression, stored in a variable only if it is used more than once. The functions have the line numbers of the
rungs' file, so that an error in a scan refers to it.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from types import CodeType, FunctionType
from typing import Any, NamedTuple

from ..model.collector import collector_paused
from ..model.errors import LadderError
from ..run.engine import Engine
from ..state.lowered import LoweredProgram
from ..state.memory import NOTHING
from ..state.tag_bytes import PUT_TEXT, text_writer
from .observed import UNOBSERVED, ForceInserter, Observation, Reading
from .positions import relocated
from .program import text_of
from .services import interpreted_of, regions_of, services

__all__ = ["ObservedScanner", "Scanner", "observed_scanner_of", "scanner_of", "source_of"]


FUNCTIONS_KEPT = 256
"""Maximum functions with cached code; an edit leaves most unchanged, and programs share libraries."""


def source_of(lowered: LoweredProgram) -> str:
    """Return the compiled Python of a program."""
    return text_of(lowered).text


Scanner = Callable[[Engine], Callable[[int], object]]
"""Binds a compiled program to an engine's memory; returns a function that runs one scan."""


class ObservedScanner(NamedTuple):
    """A compiled program that records power and applies forces."""

    bind: Callable[[Engine, Mapping[str, Any]], Callable[[int], object]]  # a `Scanner` with more variables
    note_count: int  # length of the list of noted power
    readings: Sequence[Reading]  # how to read the notes of each noted line, see `truth_of`


def scanner_of(lowered: LoweredProgram) -> Scanner:
    """Compile a program once, for any number of engines."""
    bind = observed_scanner_of(lowered, UNOBSERVED).bind
    return lambda engine: bind(engine, NOTHING)


def observed_scanner_of(lowered: LoweredProgram, observation: Observation) -> ObservedScanner:
    """Compile a program that records power and applies forces, see `observed`."""
    with collector_paused():
        text = text_of(lowered, observation)
        idents = frozenset(text.idents)
        codes = [_code(part.unit(idents), text.file, observation) for part in text.parts]
    text_names = {name for code in codes for name in code.co_names if name.startswith(PUT_TEXT)}
    regions, interpreted = regions_of(lowered), interpreted_of(lowered)

    def bind(engine: Engine, observed: Mapping[str, Any]) -> Callable[[int], object]:
        """Return the function that runs one scan of an engine, with the routines bound to its memory.

        The engine's `compiled` and `call_routine` are set to these routines.
        """
        namespace: dict[str, Any] = {**services(engine, regions, interpreted), **observed}
        for name in text_names:
            namespace[name] = text_writer(int(name[len(PUT_TEXT) :]), forced=observation.forced)
        functions: dict[str, FunctionType] = {}
        for code in codes:
            closure = tuple(engine.memory.cells[name] for name in code.co_freevars)
            # without inputs: () is the default of the last parameter
            function = FunctionType(code, namespace, code.co_name, ((),), closure)
            functions[code.co_name] = namespace[code.co_name] = function
        engine.compiled = {code: part.routine for code, part in zip(codes, text.parts, strict=True)}
        names = text.functions
        engine.call_routine = lambda name, inputs: functions[names[name]](engine.now_ns, tuple(inputs)) or ()
        if engine.scheduler is not None:
            return partial(_scheduled, engine, {key: functions[name] for key, name in names.items()})
        if engine.lowered.main in engine.lowered.functions:
            return lambda _now: engine.call_python(engine.lowered.main, ())
        return functions["scan"]

    return ObservedScanner(bind, text.noted.size, text.noted.readings)


def _scheduled(engine: Engine, functions: Mapping[str, FunctionType], now_ns: int) -> None:
    """Run one scan of a controller with compiled routines."""
    assert engine.scheduler is not None

    def run(name: str, at_ns: int) -> None:
        """Run a routine at a time within the scan, then restore the engine's scan time."""
        scan_ns, engine.now_ns = engine.now_ns, at_ns
        function = functions.get(name)
        try:
            if function is None:
                engine.call_python(name, ())
            else:
                function(at_ns, ())
        finally:
            engine.now_ns = scan_ns

    engine.scheduler.scan(now_ns, run)


def _code(unit: tuple[str, Sequence[int]], file: str, observation: Observation) -> CodeType:
    """Compile a function with the line numbers of its file; raise a LadderError if it is too large."""
    text, lines = unit
    if not observation.forced_variables:
        return _cached(text, tuple(lines), file)
    tree = ast.parse(text)
    ForceInserter(observation.forced_variables).visit(tree)
    return _compiled(tree, lines, file)


def _compiled(source: str | ast.Module, lines: Sequence[int], file: str) -> CodeType:
    """Return the code of the function inside `program`, with its line numbers; may raise a LadderError."""
    try:
        module = compile(source, file, "exec")
    except (MemoryError, RecursionError):
        raise LadderError(f"{file}: a statement has too many branches to compile; divide it") from None
    return relocated(_inner_code(_inner_code(module)), lines)


_cached = lru_cache(FUNCTIONS_KEPT)(_compiled)


def _inner_code(code: CodeType) -> CodeType:
    """Return the code of the only function that a code object defines."""
    return next(constant for constant in code.co_consts if isinstance(constant, CodeType))
