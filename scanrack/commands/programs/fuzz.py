"""`scanrack fuzz RACK`: search for conditions under which a program breaks an invariant."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import typer
from scanrack.io_images.doors import json_value
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.text_limits import TextKind
from scanrack.io_images.times import parse_duration
from scanrack.jobs.fuzz import STANDARD, Scenario
from scanrack.jobs.fuzz.folder_lock import locked
from scanrack.jobs.fuzz.job import Setup, bench_of, replay
from scanrack.jobs.fuzz.learning import LearnedScenario, learn
from scanrack.jobs.fuzz.scenarios.kinds import Kind, kinds_for, possible_kinds
from scanrack.jobs.fuzz.written_tests import check_new
from scanrack.jobs.load.loading import LoadedRack, load_job, scans_to_run
from scanrack.terminal.as_json import say_json
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.grouped import grouped
from scanrack.terminal.reading import print_notes
from scanrack.terminal.status import DONE, NO
from scanrack.terminal.terminal import say

from .fuzz_budget import Budget
from .fuzz_options import FuzzOptions
from .fuzz_session import Session
from .fuzz_summary import failure, failure_row

DEFAULT_CHECKS = ("no-command-error", "no-invalid-profile", "one-motion", "commands-end")
"""The checks that are used if neither --check nor --invariants is given."""


def _kinds(job: LoadedRack, only: Sequence[str], without: Sequence[str]) -> frozenset[Kind]:
    """Return the kinds selected by the options; without options, the kinds in the rack file."""
    if not (only or without):
        only, without = job.spec.fuzz.only, job.spec.fuzz.without
    chosen, excluded = (frozenset(map(_kind, names)) for names in (only, without))
    possible = possible_kinds(job.spec)
    for name in only:
        if _kind(name) not in possible:
            names = ", ".join(kind.value for kind in Kind if kind in possible)
            raise ValueError(f"--only {name}: not applicable to this rack; choose from {names}")
    kinds = (chosen or kinds_for(job.spec)) - excluded
    if not kinds:
        raise ValueError(f"--without {', '.join(without)}: nothing random remains")
    return kinds


def _kind(name: str) -> Kind:
    """Return the kind with a name; raise ValueError for an unknown name."""
    try:
        return Kind(name)
    except ValueError:
        raise ValueError(
            f"unknown kind {name!r}; choose from {', '.join(kind.value for kind in Kind)}"
        ) from None


def _checks(names: list[str], files: list[Path]) -> tuple[str, ...]:
    """Return the chosen checks; without checks and files, the default ones. Refuse an unknown name."""
    for name in names:
        if name not in STANDARD:
            raise ValueError(f"unknown check {name!r}; choose from {', '.join(STANDARD)}")
    return tuple(names) if names or files else DEFAULT_CHECKS


def _fuzz_command(
    options: FuzzOptions,
) -> None:
    """Search for inputs and faults that break a program.

    The search presses buttons, makes sensors stick, moves switches, cuts links and power, stops the CPU and
    tears updates, all at random. It shrinks a scenario that breaks an invariant, and writes a rack file, a
    trace with its chart, and a script for the bench, with the text of the rule. A campaign continues from the
    state in its folder. For a trace, the search runs its rack file and program, and varies the recorded
    inputs.

    Examples:
        scanrack fuzz line.toml --invariants must_hold.py --budget "10 min"

    Exit status: 0 no invariant is broken, 1 an invariant is broken, 2 a file or an option can't be used, 3 a
    file can't be written, or with --strict, a condition of @sometimes was never true, 130 stopped by Ctrl-C;
    the results so far are kept.
    """
    with reported_mistakes(), ExitStack() as resources:
        if options.tests is not None:
            check_new(options.tests)
        folder = options.out or Path(f"{Path(options.rack.partition(':')[0]).stem}-fuzz")
        learned = None
        if options.rack.endswith(".mcap"):
            resources.enter_context(locked(folder))
            learned = learn(Path(options.rack), folder / "recording", trust=options.trust)
            print_notes(learned)
        rack = options.rack if learned is None else str(learned.rack)
        job = load_job(rack)
        setup = _setup(rack, job, options, _scans(job, options.duration, learned))
        bench_of.cache_clear()  # the files may have changed since another call in this process
        bench_of(setup)  # refuse unusable files before a search begins
        if options.scenario is not None:
            raise typer.Exit(_replay(setup, options.scenario, as_json=options.as_json))
        if learned is None:
            resources.enter_context(locked(folder))
        session = Session(
            job=job,
            setup=setup,
            folder=folder,
            budget=Budget(
                options.runs, _nanoseconds(options.time), options.scans, _nanoseconds(options.processor)
            ),
            options=options,
            base=None if learned is None else learned.scenario,
        )
        status = session.run()
    raise typer.Exit(status)


def _setup(rack: str, job: LoadedRack, options: FuzzOptions, scans: int) -> Setup:
    files = tuple(options.invariants or ())
    return Setup(
        rack=rack,
        invariants=files,
        checks=_checks(options.check or [], list(files)),
        scans=scans,
        kinds=_kinds(job, options.only or [], options.without or []),
        seed=job.spec.fuzz.seed,
    )


def _nanoseconds(duration: str | None) -> int | None:
    """Return a duration in nanoseconds, or None without one."""
    return None if duration is None else parse_duration(duration)


def _scans(job: LoadedRack, duration: str | None, learned: LearnedScenario | None) -> int:
    """Return the number of scans in a run, from the command line, the recording or the rack file."""
    if learned is not None and duration is None:
        return learned.scans
    scans = scans_to_run(job.spec, duration, None, endless=False)
    assert scans is not None
    return scans


def _replay(setup: Setup, file: Path, *, as_json: bool) -> int:
    """Run a scenario, print the invariants that it breaks, and return the exit status."""
    failures = replay(bench_of(setup), read_scenario(file, setup))
    if as_json:
        say_json({"broken": [failure_row(counterexample) for counterexample in failures]})
    else:
        say("\n".join(map(failure, failures)) or "no invariant is broken")
    return NO if failures else DONE


def read_scenario(file: Path, setup: Setup) -> Scenario:
    """Read a scenario for a rack.

    Raises:
        ValueError: the file is missing, is not a scenario, or is for slots that the rack does not have.
    """
    if not file.is_file():
        raise ValueError(f"{file}: no such scenario")
    try:
        data = json_value(read_input_text(file, TextKind.SCENARIO), TextKind.SCENARIO)
        is_recipe = isinstance(data, dict) and "scenario" in data
        scenario = Scenario.from_json(data["scenario"] if is_recipe else data)
        scenario.check(bench_of(setup).spec)
    except json.JSONDecodeError as error:
        raise ValueError(f"{file}:{error.lineno}: not JSON: {error.msg}") from None
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None
    return scenario


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("fuzz", no_args_is_help=True)(grouped(_fuzz_command, options=FuzzOptions))
