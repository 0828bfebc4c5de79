"""`scanrack fuzz RACK`: look for surroundings in which a program breaks what must hold."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from textwrap import wrap
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from ...io_images.amci3601 import ERROR_BITS, RULES
from ..fuzz import STANDARD, Found, InvariantError, Scenario
from ..fuzz.campaign import RECORDING, CampaignError, State, Work, campaign, read_state, write_state
from ..fuzz.scenarios import Kind, kinds_for
from ..pace import wall_ns
from ..quantities import parse_duration
from .fuzzing import Setup, bench_of, hand_over, replay
from .fuzzing import Work as SearchWork
from .learning import learn
from .loading import Job, load_job, scans_to_run

HELD, BROKEN, BAD_INPUT, CANNOT_WRITE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit status: everything held; something is broken; bad input; a file can't be written; Ctrl-C."""

DEFAULT_CHECKS = ("no-command-error", "no-invalid-profile", "one-motion")
"""What is checked if neither --check nor --invariants is given."""

WIDTH = 100

PER_TASK = 50
"""Scenarios per task."""


class Here(Executor):
    """Does every task at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Do it, and return what came out of it."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # it is raised where the result is asked for
            future.set_exception(error)
        return future


class OnCluster(Executor):
    """Has tasks done by a Dask cluster, and leaves it when it is shut down.

    Args:
        client: a `distributed.Client`.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self._executor: Executor = client.get_executor(pure=False)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send it to a worker."""
        return self._executor.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Close the connection; the cluster goes on."""
        self._executor.shutdown(wait=wait)
        self._client.close()


def executor_of(jobs: int, dask: str | None) -> Callable[[], Executor]:
    """Return what makes the executor: this process, a pool of processes, or a Dask cluster.

    Raises:
        ValueError: the cluster's library is missing, or nothing answers at its address.
    """
    if dask is not None:
        return lambda: _dask(dask)
    if jobs == 1:
        return Here
    return lambda: ProcessPoolExecutor(jobs, mp_context=get_context("spawn"))


def _dask(address: str) -> Executor:
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise ValueError("a cluster needs dask: pip install 'scanrack[cluster]'") from None
    try:
        client: Any = Client(address, timeout=10)  # type: ignore[no-untyped-call, unused-ignore]
    except OSError as error:
        raise ValueError(f"no Dask scheduler answers at {address}: {error}") from error
    return OnCluster(client)


class _Teller:
    """Shows how far a campaign is, and decides when it is over."""

    def __init__(self, state: State, bar: Progress | None, task: Any, deadline: int | None) -> None:
        self._state, self._bar, self._task, self._deadline = state, bar, task, deadline
        self._before = state.tasks

    def update(self) -> None:
        if self._bar is not None:
            done = self._state.tasks - self._before
            text = f"{self._state.runs:,} runs, {len(self._state.found)} broken"
            self._bar.update(self._task, completed=done, description=text)

    def go_on(self) -> bool:
        return self._deadline is None or wall_ns() < self._deadline


@contextmanager
def _shown(state: State, tasks: int | None, deadline: int | None, *, quiet: bool) -> Iterator[_Teller]:
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield _Teller(state, None, None, deadline)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as bar:
        yield _Teller(state, bar, bar.add_task("searching", total=tasks), deadline)


def _kinds(job: Job, only: list[str], without: list[str]) -> frozenset[Kind]:
    names = {kind.value: kind for kind in Kind}
    for name in (*only, *without):
        if name not in names:
            raise ValueError(f"unknown kind {name!r}: allowed are {', '.join(names)}")
    kinds = frozenset(names[name] for name in only) if only else kinds_for(job.spec)
    return kinds - {names[name] for name in without}


def _checks(given: list[str], files: list[Path]) -> tuple[str, ...]:
    for name in given:
        if name not in STANDARD:
            raise ValueError(f"unknown check {name!r}: allowed are {', '.join(STANDARD)}")
    return tuple(given) if given or files else DEFAULT_CHECKS


def summary(state: State, before: State, seconds: float) -> str:
    """Return what a campaign came to, for people."""
    runs, scans = state.runs - before.runs, state.scans - before.scans
    rate = f" ({runs / seconds:,.0f} runs and {scans / seconds:,.0f} scans per second)" if seconds else ""
    lines = [f"runs          {runs:,}{rate}"]
    if before.runs:
        lines.append(f"in all        {state.runs:,} runs, {state.scans:,} scans")
    told = [rule.id for rule in RULES.values() if rule.list_of and rule.list_of & ERROR_BITS.value]
    fired = [rule for rule in told if state.rules[rule]]
    lines.append(f"error rules   {len(fired)} of {len(told)} of chapter 6 fired")
    lines += [f"  {rule:<9} {state.rules[rule]:>9,} times" for rule in fired]
    never = ", ".join(rule for rule in told if not state.rules[rule])
    lines += wrap(never, WIDTH, initial_indent="  never     ", subsequent_indent=" " * 12)
    return "\n".join(lines)


def _fuzz_command(
    rack: Annotated[
        str,
        typer.Argument(
            metavar="RACK", help="Rack file: TOML, or Python that defines rack(). Or a trace, to vary it."
        ),
    ],
    invariants: Annotated[
        list[Path] | None,
        typer.Option("--invariants", "-i", metavar="FILE", help="Python file with what must hold."),
    ] = None,
    check: Annotated[
        list[str] | None,
        typer.Option("--check", metavar="NAME", help=f"Something that must hold: {', '.join(STANDARD)}."),
    ] = None,
    duration: Annotated[
        str | None, typer.Option("--for", metavar="TIME", help="Machine time of a run, such as '10 s'.")
    ] = None,
    runs: Annotated[
        int, typer.Option("--runs", min=1, help="How many scenarios to try, less those of shrinking.")
    ] = 500,
    time: Annotated[
        str | None, typer.Option("--time", metavar="TIME", help="Search for so long instead: '2 h'.")
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option("--only", metavar="KIND", help=f"What is random: {', '.join(k.value for k in Kind)}."),
    ] = None,
    without: Annotated[
        list[str] | None, typer.Option("--without", metavar="KIND", help="What is not.")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, help="Searches at a time.", show_default="cores")
    ] = None,
    dask: Annotated[
        str | None, typer.Option("--dask", metavar="ADDRESS", help="Search on a Dask cluster.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="FOLDER", help="Where everything goes.", show_default="RACK-fuzz"
        ),
    ] = None,
    scenario: Annotated[
        Path | None, typer.Option("--scenario", metavar="FILE", help="Run just this scenario.")
    ] = None,
    trust: Annotated[bool, typer.Option("--trust", help="Run Python that came with the trace.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar and no summary.")] = False,
) -> None:
    """Look for surroundings in which a rack's program breaks what must hold.

    Buttons are pressed, sensors stick, switches are elsewhere, links are lost, power goes, the CPU is
    stopped, updates are torn, all at random. What breaks an invariant is shrunk, and handed over as a
    rack file, a trace with its chart, and a script for the bench, with the sentence of the rule.
    A campaign goes on where it left off: its state is in the same folder.
    Of a trace, the rack file and the program in it are searched, and what acted on the inputs is varied.

    Example: scanrack fuzz line.toml --invariants must_hold.py --time "10 min"

    Exit status: 0 everything held, 1 something is broken, 2 a file or an option can't be used, 3 a file
    can't be written, 130 stopped by Ctrl-C; what is known by then is kept.
    """
    try:
        folder = out or Path(f"{Path(rack.partition(':')[0]).stem}-fuzz")
        learned = learn(Path(rack), folder / "recording", trust=trust) if rack.endswith(".mcap") else None
        if learned is not None:
            rack = str(learned.rack)
        job = load_job(rack)
        recorded = learned.scans if learned is not None and duration is None else None
        scans = scans_to_run(job.spec, duration, recorded, endless=False)
        assert scans is not None
        files = tuple(invariants or ())
        setup = Setup(
            rack, files, _checks(check or [], list(files)), scans, _kinds(job, only or [], without or [])
        )
        bench_of(setup)  # what can't be used is told before a search begins
        if scenario is not None:
            raise typer.Exit(_replay(job, setup, scenario))
        limit = None if time is None else parse_duration(time)
        base = None if learned is None else learned.scenario
        status = _campaign(
            job, setup, folder, runs, limit, jobs or os.cpu_count() or 1, dask, base=base, quiet=quiet
        )
    except (CampaignError, InvariantError, ValueError) as error:
        _complain(str(error))
        raise typer.Exit(BAD_INPUT) from error
    except OSError as error:
        _complain(f"{error.filename}: {error.strerror}")
        raise typer.Exit(CANNOT_WRITE) from error
    raise typer.Exit(status)


def _replay(job: Job, setup: Setup, file: Path) -> int:
    try:
        scenario = Scenario.from_json(json.loads(file.read_text(encoding="utf-8")))
    except json.JSONDecodeError as error:
        raise ValueError(f"{file}:{error.lineno}: this is no JSON: {error.msg}") from None
    found = replay(bench_of(setup), scenario)
    typer.echo("everything held" if found is None else str(found.broken))
    return HELD if found is None else BROKEN


def _campaign(
    job: Job,
    setup: Setup,
    folder: Path,
    runs: int,
    limit_ns: int | None,
    jobs: int,
    dask: str | None,
    *,
    base: Scenario | None,
    quiet: bool,
) -> int:
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "state.json"
    state, before = read_state(file), read_state(file)
    if base is not None:
        state.corpus = {RECORDING: base, **state.corpus}
    tasks = None if limit_ns is not None else -(-runs // PER_TASK)
    examples = min(runs, PER_TASK)
    start_ns = wall_ns()
    deadline = None if limit_ns is None else start_ns + limit_ns
    work: Work = SearchWork(setup)
    status = HELD
    with _shown(state, tasks, deadline, quiet=quiet) as teller:

        def news(found: list[Found]) -> None:
            for each in found:
                hand_over(job, bench_of(setup), each, folder / each.broken.invariant)
            write_state(state, file)
            teller.update()

        try:
            campaign(
                work,
                state,
                executor_of(jobs, dask),
                examples=examples,
                tasks=tasks,
                jobs=jobs,
                go_on=teller.go_on,
                news=news,
            )
        except KeyboardInterrupt:
            status = INTERRUPTED
    for each in state.found.values():
        typer.echo(f"{each.broken}\n  see {folder / each.broken.invariant}")
    if not quiet:
        typer.echo(summary(state, before, (wall_ns() - start_ns) / 1e9))
    return status or (BROKEN if state.found else HELD)


def _complain(text: str) -> None:
    typer.echo(f"scanrack: {text}", err=True)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("fuzz", no_args_is_help=True)(_fuzz_command)
