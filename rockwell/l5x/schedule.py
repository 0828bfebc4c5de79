"""Tasks of a document."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping
from decimal import Decimal, InvalidOperation
from enum import Enum
from typing import Any

from scanrack.io_images.times import exact_ns
from scanrack.ladder.model.chart import ChartOptions, ExecutionControl, LastScan, RestartPosition
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.schedule import PRIORITIES, Task, TaskKind

from .report import Report
from .xml.elements import number_of
from .xml.records import L5xDocument, TaskRecord


def tasks_of(document: L5xDocument, programs: Iterable[str], report: Report) -> list[Task]:
    """Return the tasks of a document; report omitted tasks and programs.

    A program runs in the first task that lists it.
    """
    unscheduled = {name.upper(): name for name in programs}
    disabled = {program.name.upper() for program in document.programs if program.disabled}
    tasks: list[Task] = []
    names: set[str] = set()
    for record in document.tasks:
        if record.name.upper() in names:
            report.note(f"task {record.name}", "there are two tasks of that name", record.line)
            continue
        names.add(record.name.upper())
        if record.inhibited:
            report.note(f"task {record.name}", "it is inhibited, and does not run", record.line)
            for name in record.programs:
                unscheduled.pop(name.upper(), None)
            continue
        task = _task(record, tuple(_take_programs(record, unscheduled, disabled, report)), report)
        if task is None:
            continue
        has_continuous = any(earlier.kind is TaskKind.CONTINUOUS for earlier in tasks)
        if not (has_continuous and task.kind is TaskKind.CONTINUOUS):  # a controller has at most one
            tasks.append(task)
    return tasks


def _take_programs(
    record: TaskRecord, unscheduled: dict[str, str], disabled: Container[str], report: Report
) -> Iterator[str]:
    """Remove the programs of a task from `unscheduled`; yield the programs that run."""
    for name in record.programs:
        program_name = unscheduled.pop(name.upper(), None)
        if program_name is None:
            report.note(f"task {record.name}", f"no program {name} for it", record.line)
        elif name.upper() in disabled:
            report.note(f"program {name}", "it is disabled, and does not run", record.line)
        else:
            yield program_name


_CHART_OPTIONS: tuple[Mapping[str, Enum], ...] = (
    {"CurrentActive": ExecutionControl.CURRENT, "UntilFalse": ExecutionControl.UNTIL_FALSE},
    {"MostRecent": RestartPosition.MOST_RECENT, "InitialStep": RestartPosition.INITIAL},
    {
        "DontScan": LastScan.DONT_SCAN,
        "ProgrammaticReset": LastScan.PROGRAMMATIC,
        "AutomaticReset": LastScan.AUTOMATIC,
    },
)
"""The values of each chart option, by their text in a document [1756-RM014, controller attributes]."""


def chart_options_of(document: L5xDocument, report: Report) -> ChartOptions:
    """Return a document's chart options; a missing or invalid option gets the first value of its row."""
    chosen: list[Any] = []
    for text, options in zip(document.charts, _CHART_OPTIONS, strict=True):
        by_text = dict(options) | {name.removesuffix("Reset"): option for name, option in options.items()}
        option = by_text.get(text) or next(iter(options.values()))
        if text and text not in by_text:
            choices = ", ".join(options)
            report.note("options of charts", f"{text!r} is not one of {choices}; it is {option.value}")
        chosen.append(option)
    return ChartOptions(*chosen)


def _task(record: TaskRecord, programs: tuple[str, ...], report: Report) -> Task | None:
    """Return a task; if its record is invalid, add a note and return None."""
    kinds = {task_kind.value: task_kind for task_kind in TaskKind}
    kind = kinds.get(record.kind)
    try:
        rate = Decimal(record.rate or 0) if kind is TaskKind.PERIODIC else Decimal(0)
        priority = number_of(record.priority)
        if kind is None:
            raise LadderError(f"its type is {record.kind}; choose from {', '.join(kinds)}")
        if priority is None or priority not in PRIORITIES:
            priority = 10
        return Task(
            record.name, kind, programs, exact_ns(rate, "ms", "its rate"), priority, comment=record.comment
        )
    except (LadderError, InvalidOperation, OverflowError, ValueError) as error:
        report.note(f"task {record.name}", f"it does not run: {error}", record.line)
        return None
