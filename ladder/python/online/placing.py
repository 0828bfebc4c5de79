"""Moves the frames of a sequence to edited code; all moves are planned before the first one.

    cycle          awaits self.make_round()            rebuilt, awaits the rebuilt make_round
      make_round   awaits within("5 s", ...)           rebuilt, awaits the same wait
        within     awaits a command                    stays

Nothing changes until the whole edit has been planned.
"""

from __future__ import annotations

import ast
import gc
from collections.abc import Callable, Coroutine, Mapping
from enum import Enum
from functools import partial
from pathlib import Path
from types import CodeType, FunctionType, GeneratorType, MethodType
from typing import Any, TypeVar

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site, SiteError

from ..sequences.coroutine import Sequence
from ..sequences.parts import Part
from ..sequences.waits import Wait, stepping
from .conditions import OURS, Texts, branches_in, check_wait
from .edition import Edition
from .held import ContinuedAwait, keep_forever
from .locals_fit import check_bound, check_origins, check_unchanged, names_needed, names_read
from .points import Function, PlacedAwait, Point, counterpart, points_of
from .resumed import ResumptionBody, arguments_of, compiled, resume
from .suspended import BlockKind, UnknownStackError, WaitingFrame, suspended

Work = Coroutine[Any, Any, object]
T = TypeVar("T")


class NotPlacedError(SiteError):
    """A sequence can't continue in the edited program; the error's sites show where it was waiting."""


@dataclass(frozen=True, slots=True)
class EditContext:
    """The data of an edit that all frames share."""

    old: Edition
    new: Edition
    codes: frozenset[CodeType]  # codes of rebuilt or kept frames in the current edition
    changed: tuple[Part, ...]  # parts that the edit changes
    names: frozenset[str]  # names, and attributes with a dot, that the edit changes
    texts: Texts  # syntax of the functions in waits

    def check_wait(self, wait: Wait[Any]) -> None:
        """Raise a ConditionError if a wait can't continue."""
        check_wait(wait, (self.old, self.new), self.changed, self.texts)


@dataclass(frozen=True, slots=True)
class FrameMove:
    """A frame and its function in the edited program."""

    frame: WaitingFrame
    function: FunctionType
    target: PlacedAwait
    resumed: ResumptionBody
    values: dict[str, Any]  # locals
    block_objects: list[Any]  # objects of open blocks, outermost first


@dataclass(frozen=True, slots=True)
class SequenceMove:
    """The frames of a sequence or branch, outermost first."""

    sequence: Sequence
    frames: tuple[FrameMove, ...]  # empty if they stay
    kept: tuple[CodeType, ...] = ()  # the codes of frames that stay

    def move(self) -> list[CodeType]:
        """Rebuild the frames, innermost first, and run them up to the wait; return their codes."""
        if not self.frames:
            return list(self.kept)
        wait, old_work = self.sequence._wait, self.sequence._work
        awaited: Any = ContinuedAwait(self.frames[-1].frame.awaited, wait)
        codes = []
        for frame in reversed(self.frames):
            function = compiled(frame.target.function, frame.resumed, tuple(frame.values), frame.function)
            point = frame.target.point
            arguments = arguments_of(
                frame.resumed,
                point.block_kinds,
                frame.block_objects,
                awaited,
                entry=isinstance(point.node, ast.AsyncWith),
            )
            awaited = function(**frame.values, **arguments)
            codes.append(function.__code__)
        keep_forever(old_work)
        self.sequence._work = awaited
        _begin(awaited, wait)
        return codes


def _begin(work: Work, wait: Wait[Any] | None) -> None:
    """Run a rebuilt frame up to its await; this runs no user code."""
    was_stepping, stepping.active = stepping.active, True
    try:
        awaited = work.send(None)
    finally:
        stepping.active = was_stepping
    assert awaited is wait, "a rebuilt frame begins at its await"


def plan_moves(sequence: Sequence, context: EditContext) -> list[SequenceMove]:
    """Plan how a waiting sequence, and the branches in its wait, continue.

    Raises:
        NotPlacedError: it is not certain that the sequence can continue.
    """
    wait, work = sequence._wait, sequence._work
    assert wait is not None, "the sequence waits"
    waiting = []
    while (frame := _user_frame(work)) is not None:
        waiting.append(frame)
        work = work.cr_await  # type: ignore[union-attr]
    if not waiting:
        raise NotPlacedError(f"{sequence.name} waits in no function of the program")
    name, last = sequence.name, waiting[-1]
    _checked(name, last, lambda: context.check_wait(wait))
    if all(_is_unchanged(frame, context) for frame in waiting):
        for frame in waiting:
            _checked(name, frame, partial(_check_locals, frame.values, context))
        moves = [SequenceMove(sequence, (), tuple(frame.code for frame in waiting))]
    else:
        planned = [_checked(name, frame, partial(_move_of, frame, context)) for frame in waiting]
        moves = [SequenceMove(sequence, tuple(planned))]
    for branch in branches_in(wait):
        moves += plan_moves(branch, context)
    return moves


def _user_frame(work: Any) -> WaitingFrame | None:
    """Return the frame of a user's coroutine; None for other coroutines."""
    if getattr(work, "cr_frame", None) is None or work.cr_await is None:
        return None
    module = work.cr_frame.f_globals.get("__name__", "")
    return None if module.startswith(OURS) else suspended(work)


def _checked(name: str, frame: WaitingFrame, check: Callable[[], T]) -> T:
    """Return the result of a check; if it fails, raise a NotPlacedError with the reason and the line."""
    try:
        return check()
    except UnknownStackError:
        reason = "the objects in its open blocks can't be read in this Python version"
    except ValueError as error:
        reason = str(error)
    file, line = frame.code.co_filename, frame.work.cr_frame.f_lineno
    position = f"{name} waits in {frame.code.co_name}"
    raise NotPlacedError.at(Site(file=Path(file).name, line=line), f"{position}: {reason}")


def _functions_of(frame: WaitingFrame, context: EditContext) -> tuple[FunctionType, FunctionType]:
    """Return the function of a frame in the current and in the edited program."""
    qualified = frame.code.co_qualname
    present = context.old.function(frame.module, qualified)
    edited = context.new.function(frame.module, qualified)
    if present is None or (present.__code__ is not frame.code and frame.code not in context.codes):
        raise ValueError("it still runs an earlier edition of the program; edit again after that has ended")
    if edited is None:
        raise ValueError(f"{qualified} no longer exists")
    return present, edited


def _trees_of(frame: WaitingFrame, context: EditContext) -> tuple[Function, Function]:
    """Return the syntax of a frame's function in both programs; raise a ValueError if it is missing."""
    present, edited = _functions_of(frame, context)
    old_tree, new_tree = context.old.tree(present), context.new.tree(edited)
    if not isinstance(old_tree, ast.AsyncFunctionDef) or not isinstance(new_tree, ast.AsyncFunctionDef):
        name = frame.code.co_qualname
        raise ValueError(f"{name} has no source, or is not an `async def`")
    return old_tree, new_tree


def _is_unchanged(frame: WaitingFrame, context: EditContext) -> bool:
    """Return whether the text and lines of a frame's function are unchanged, so that the frame can stay."""
    try:
        old_tree, new_tree = _trees_of(frame, context)
    except ValueError:
        return False
    if "__class__" in frame.code.co_freevars:
        return False
    names = set(frame.code.co_names)
    if names & (context.old.rebound | context.new.rebound | {name.lstrip(".") for name in context.names}):
        return False
    return ast.dump(old_tree, include_attributes=True) == ast.dump(new_tree, include_attributes=True)


def _point_of(frame: WaitingFrame, points: list[Point]) -> Point:
    """Return the await where a frame waits; raise a ValueError if no await matches."""
    matching = [point for point in points if point.is_at(frame.position)]
    if len(matching) != 1:
        raise ValueError("its await is not in the source")
    if _leaves_block(frame, matching[0]):
        raise ValueError("it leaves an `async with`")
    return matching[0]


def _check_locals(values: Mapping[str, Any], context: EditContext) -> None:
    """Raise a ValueError for a local that refers to an object that does not continue."""
    for name, value in values.items():
        _check_local(name, value, context)


def _loops(point: Point, held: list[Any], context: EditContext) -> tuple[list[Any], list[str]]:
    """Return the open blocks' objects for the edited program, and the heads of loops over an edited tuple.

    A loop over an edited tuple continues if its passes so far are the same.

    Raises:
        LocalsError: the passes differ, or the loop is not over a constant tuple.
    """
    loops = [block for block in point.steps if isinstance(block.node, ast.For) and block.field == "body"]
    iterator_indices = [index for index, kind in enumerate(point.block_kinds) if kind is BlockKind.ITERATOR]
    iterators, heads = list(held), []
    for index, step in zip(iterator_indices, loops, strict=True):
        node: Any = step.node
        if not names_read(node.iter) & context.names:
            continue
        iterator = _iterator_at_same_pass(held[index], ast.unparse(node.iter), context)
        if iterator is None:
            check_unchanged(f"it is in `{step.head}`", names_read(node.iter), context.names)
        iterators[index] = iterator
        heads.append(f"{step.head}:")
    return iterators, heads


_TUPLE_ITERATOR: type[Any] = type(iter(()))


def _iterator_at_same_pass(iterator: Any, text: str, context: EditContext) -> Any:
    """Return an iterator over the edited tuple, at the same pass; None if the passes so far may differ."""
    old, new = (edition.constant(text) for edition in (context.old, context.new))
    if type(iterator) is not _TUPLE_ITERATOR or not isinstance(old, tuple) or not isinstance(new, tuple):
        return None
    passes = len(old) - iterator.__length_hint__()
    if iterator.__reduce__()[1] != (old,) or old[:passes] != new[:passes]:
        return None
    remaining = iter(new)
    for _ in range(passes):
        next(remaining)
    return remaining


def _move_of(frame: WaitingFrame, context: EditContext) -> FrameMove:
    """Plan how a frame continues in its edited function; raise a ValueError if that is not certain."""
    _, edited = _functions_of(frame, context)
    present_tree, edited_tree = _trees_of(frame, context)
    points = points_of(present_tree)
    point = _point_of(frame, points)
    target = counterpart(point, points, points_of(edited_tree))
    old_await, new_await = PlacedAwait(present_tree, point), PlacedAwait(edited_tree, target)
    resume(present_tree, point)  # raises a CannotBeginError if the frame can't be read
    resumed = resume(edited_tree, target)
    held = frame.block_objects(point.block_kinds)
    _check_held(held, context)
    held, loops = _loops(target, held, context)
    values = _fitting(frame, old_await, new_await, resumed, edited, context, loops)
    return FrameMove(frame, edited, new_await, resumed, values=values, block_objects=held)


def _leaves_block(frame: WaitingFrame, point: Point) -> bool:
    """Return whether a frame waits in the exit of an `async with`."""
    inside = getattr(frame.work.cr_await, "cr_code", None)
    entry = isinstance(point.node, ast.AsyncWith)
    return entry and inside is not None and inside.co_name == "__aexit__"


def _fitting(
    frame: WaitingFrame,
    old_await: PlacedAwait,
    new_await: PlacedAwait,
    resumed: ResumptionBody,
    edited: FunctionType,
    context: EditContext,
    loops: list[str],
) -> dict[str, Any]:
    """Return the locals for the edited function."""
    code = edited.__code__
    local_names = [name for name in (*code.co_varnames, *code.co_cellvars) if not name.startswith(".")]
    values = {name: frame.values[name] for name in local_names if name in frame.values}
    needed = names_needed(resumed.body, new_await.point)
    if ast.dump(old_await.function) != ast.dump(new_await.function):
        check_bound(needed, local_names, values)
    check_origins(needed & frozenset(local_names), old_await, new_await, context.names, loops)
    _check_locals({name: values[name] for name in sorted(needed & values.keys())}, context)
    return values


def _check_local(name: str, value: Any, context: EditContext) -> None:
    """Raise a ValueError for a local that refers to an object that does not continue."""
    if any(value is item for item in context.changed):
        raise ValueError(f"its local {name} is {value.name}, whose declaration has changed")
    if isinstance(value, Wait):
        context.check_wait(value)
    elif isinstance(value, FunctionType | Coroutine):
        raise ValueError(f"its local {name} is a function or a coroutine of the previous program")
    else:
        description = foreign_object_in(value, context.old)
        if description and not isinstance(value, context.old.kind):
            raise ValueError(f"its local {name} is {description}")


def _check_held(held: list[Any], context: EditContext) -> None:
    """Raise a ValueError if an open block's object runs code of the program, or does not continue."""
    for value in held:
        owner = getattr(value, "__self__", value)
        if not isinstance(owner, BaseException) and not _is_library(owner):
            raise ValueError(f"a loop or a `with` uses an object of the class {type(owner).__name__}")
        if any(owner is part for part in context.changed):
            raise ValueError(f"a `with` uses {owner.name}, whose declaration has changed")


_CODE = (GeneratorType, FunctionType, MethodType, Coroutine)
"""Types of objects that may run user code."""


def _is_library(owner: Any, depth: int = 3) -> bool:
    """Return whether an iterator or context manager runs no code of the program."""
    module = type(owner).__module__
    if module.startswith(OURS):
        return True
    if module == "contextlib":
        return type(owner).__name__ in ("suppress", "nullcontext")
    if module not in ("builtins", "itertools") or isinstance(owner, _CODE):
        return False
    inner = [
        referent
        for referent in gc.get_referents(owner)
        if hasattr(referent, "__next__") or isinstance(referent, _CODE)
    ]
    return all(depth > 0 and _is_library(item, depth - 1) for item in inner)


def foreign_object_in(value: Any, old: Edition, depth: int = 4) -> str:
    """Describe the first object in a value whose class the program defines; "" if there is none."""
    kind = type(value)
    if kind.__module__ in old.modules:
        name = f"{kind.__name__}.{value.name}" if isinstance(value, Enum) else f"a {kind.__name__}"
        return f"{name} of the previous program"
    if isinstance(value, dict):
        value = [*value, *value.values()]
    if depth and isinstance(value, list | tuple | set | frozenset):
        return next((text for item in value if (text := foreign_object_in(item, old, depth - 1))), "")
    return ""
