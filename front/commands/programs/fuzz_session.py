"""A session of `scanrack fuzz`: confirm known failures, search, report, write the files."""

from __future__ import annotations

import errno
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from signal import default_int_handler
from threading import current_thread, main_thread
from types import FrameType

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TaskProgressColumn, TextColumn, TimeElapsedColumn

from ...jobs.fuzz import Counterexample, Scenario, undisturbed
from ...jobs.fuzz.campaign.campaign import campaign
from ...jobs.fuzz.campaign.confirming import Confirmation
from ...jobs.fuzz.campaign.executors import executor_of
from ...jobs.fuzz.campaign.memory import Memory
from ...jobs.fuzz.campaign.recipes import Origin
from ...jobs.fuzz.campaign.state import RECORDING, CampaignError, State, read_state, write_state
from ...jobs.fuzz.campaign.working import OwnProcess, Work
from ...jobs.fuzz.explain.coverage import coverage_of
from ...jobs.fuzz.explain.coverage_page import coverage_line, save_coverage
from ...jobs.fuzz.folder_lock import STATE_NAME
from ...jobs.fuzz.job import Setup, bench_of, hand_over
from ...jobs.fuzz.report import mended
from ...jobs.fuzz.run import NO_FAULT, BrokenInvariant, TrialBench
from ...jobs.fuzz.steady import Uses
from ...jobs.load.loading import Job
from ...jobs.prove.serving.aims import dead
from ...jobs.prove.serving.stuck import SolverStep
from ...runtime.loop.pace import interrupted_by, wall_ns
from ...runtime.modules.record import Trait
from ...runtime.modules.registry import has
from ...terminal.as_json import say_json
from ...terminal.status import DONE, INTERRUPTED, NO, NOT_SEEN, complain
from ...terminal.terminal import on_a_line, say
from .fuzz_summary import closing, failure, failure_row, goals, held, not_kept, summary, summary_row

MOST_RUNS, LEAST_RUNS, SCANS, LINKED_SCANS = 50, 10, 150_000, 15_000
"""Scenarios per task: the number for this many scans, a few seconds' work, within these limits.

With an adapter in the rack a scan takes at least ten times as long.
"""

MOST_COVERED = 60
"""Largest number of runs whose coverage is shown: the first of each new thing."""

COVERAGE = "coverage.html"
"""File of the page of coverage."""

FULL = (errno.ENOSPC, errno.EDQUOT)
"""Errors of a full disk."""


@contextmanager
def noting_ctrl_c() -> Iterator[Callable[[], bool]]:
    """Raise KeyboardInterrupt on Ctrl-C, and note it even if the exception is swallowed; yield the note.

    An ignored signal, as in the background of a shell, and a foreign handler stay as they are.
    """
    times = 0

    def note(_number: int, _frame: FrameType | None) -> None:
        nonlocal times
        times += 1
        raise KeyboardInterrupt

    if current_thread() is not main_thread() or signal.getsignal(signal.SIGINT) is not default_int_handler:
        yield lambda: False
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: times > 0
    finally:
        signal.signal(signal.SIGINT, default_int_handler)


@dataclass(frozen=True, slots=True)
class Budget:
    """How long a session searches: the limit that is reached first; the runs count without any other."""

    runs: int  # number of scenarios
    wall_ns: int | None = None
    scans: int | None = None
    processor_ns: int | None = None  # of all workers

    @property
    def is_by_runs(self) -> bool:
        """Whether only the runs count."""
        return self.wall_ns is None and self.scans is None and self.processor_ns is None

    def is_left(self, state: State, before: State, used_ns: int) -> bool:
        """Return whether the search may go on."""
        used = used_ns, state.scans - before.scans, state.processor_ns
        limits = self.wall_ns, self.scans, self.processor_ns
        return all(limit is None or each < limit for each, limit in zip(used, limits, strict=True))


@dataclass(frozen=True, slots=True)
class Session:
    """The options of one call of the command."""

    job: Job
    setup: Setup
    folder: Path
    budget: Budget
    jobs: int | None  # tasks at a time; None = as many as the cluster has threads
    dask: str | None  # address of a Dask scheduler, or None
    base: Scenario | None  # the scenario of a recording, or None
    begin_with: tuple[Path, ...]  # folders of other campaigns and recordings, whose runs are tried first
    quiet: bool  # print only failures
    as_json: bool = False
    strict: bool = False  # whether it counts if a goal was never seen

    @property
    def state_file(self) -> Path:
        """The file of the campaign's state."""
        return self.folder / STATE_NAME

    @property
    def examples(self) -> int:
        """Number of scenarios per task."""
        return self._most_examples if self.tasks is None else -(-self.budget.runs // self.tasks)

    @property
    def tasks(self) -> int | None:
        """Number of tasks; None = limited by the budget only."""
        return -(-self.budget.runs // self._most_examples) if self.budget.is_by_runs else None

    @property
    def _most_examples(self) -> int:
        linked = any(has(slot.module, Trait.LINE) for slot in self.job.spec.slot)
        return min(MOST_RUNS, max(LEAST_RUNS, (LINKED_SCANS if linked else SCANS) // self.setup.scans))

    def run(self) -> int:
        """Search; return the exit status. The caller holds the folder, see `locked`.

        Raises:
            ValueError: an unusable file or option.
            OSError: a file can't be written.
        """
        start_ns = wall_ns()
        bench = bench_of(self.setup)
        state = read_state(self.state_file, os.path.relpath(self.setup.rack, self.folder))
        for old in state.leave_out_impossible(bench.spec):
            self._tell(
                f"left out: {old.sentence.rstrip('.')} [{old.invariant}]: the program needs newer firmware"
            )
        before = replace(state)
        memory = Memory(self.folder, Origin.of(self.job, self.setup.scans), bench.spec, complain)
        again = memory.known(self.begin_with)
        if self.base is not None:
            state.corpus = {RECORDING: self.base, **state.corpus}
        self._look_again(bench, state)
        again += tuple(self._shrink_what_is_left(bench, state, memory))
        self._keep(bench, state, memory, state.note(self._undisturbed(bench, state)))
        status = DONE
        solver = SolverStep(self.job)
        if self._can_be_searched(state):
            status = self._search(bench, state, memory, again, solver, start_ns)
        broken = [each for _, each in sorted(state.found.items()) if each.broken.invariant in bench.names]
        others = bench.names - {each.broken.invariant for each in broken}
        if self.as_json:
            rows = [failure_row(each, self._folder_of(state, each.broken)) for each in broken]
            say_json({"broken": rows, **summary_row(state, before, others)})
            return self._status(status, bench, state)
        if not self.quiet:
            say(summary(state, before, (wall_ns() - start_ns) / 1e9))
            say("\n".join([held(others, state), *goals(bench.goals, state)]))
            if status == DONE:  # not of a session that was stopped: it takes some runs
                say(self._cover(bench, state))
            say(closing(self.job, state, solver, self.setup.scans))
        for each in broken:
            say(f"{failure(each)}\n  see {self._folder_of(state, each.broken)}")
        return self._status(status, bench, state)

    def _cover(self, bench: TrialBench, state: State) -> str:
        """Write the page of coverage; return its line of the summary."""
        runs = [self.base or Scenario(), *(each.scenario for each in state.kept.entries)][:MOST_COVERED]
        proved = [
            (each.site.routine, each.site.rung, each.site.instruction, each.state.value)
            for each in dead(self.job)
        ]
        lines = coverage_of(bench, runs, self.job.program, proved)
        page = self.folder / COVERAGE
        save_coverage(page, f"Coverage of {self.job.program.name}", lines, len(runs))
        return f"coverage      {coverage_line(lines)}, see {page}"

    def _status(self, status: int, bench: TrialBench, state: State) -> int:
        """Return the exit status: what went wrong before what is broken, before what was never seen."""
        broken = any(each.broken.invariant in bench.names for each in state.found.values())
        unseen = self.strict and any(each.name not in state.applied for each in bench.goals)
        return status or (NO if broken else NOT_SEEN if unseen else DONE)

    def _undisturbed(self, bench: TrialBench, state: State) -> list[Counterexample]:
        """Run the program without disturbances; report its use of values that may differ between runs."""
        uses = Uses()
        found = undisturbed(
            uses.watching(bench), self.base or Scenario(), state.found, confirm=Confirmation(self.setup)
        )
        if uses.seen:
            complain(f"the program uses {uses}: it may not do the same twice in the same surroundings")
        return found

    def _tell(self, text: str) -> None:
        say(text, err=self.as_json)

    def _look_again(self, bench: TrialBench, state: State) -> None:
        """Repeat known failures, and report those that are gone."""
        for broken in state.recheck(bench):
            self._tell(f"mended: {broken.sentence.rstrip('.')} [{broken.invariant}]")
            mended(self._folder_of(state, broken) / "report.txt")

    def _can_be_searched(self, state: State) -> bool:
        """Return whether the program can be searched; if not, report why."""
        faults = [each for each in state.found.values() if each.broken.invariant == NO_FAULT]
        if any(not each.scenario.size for each in faults):
            complain("the program faults with nothing random around it: mend that, then search")
            return False
        return True

    def _shrink_what_is_left(self, bench: TrialBench, state: State, memory: Memory) -> Iterator[Scenario]:
        """Shrink what an earlier session has found before it was killed; yield what holds now."""
        for file, recipe in memory.left():
            if recipe.broken and recipe.broken not in bench.names:
                continue  # of an invariant that this session does not have
            found = undisturbed(bench, recipe.scenario, state.found, confirm=Confirmation(self.setup))
            if not found and recipe.origin.scans > self.setup.scans:
                continue  # its run is longer than those of this session
            self._keep(bench, state, memory, state.note(found))
            file.unlink(missing_ok=True)
            if not found:
                yield recipe.scenario

    def _search(
        self,
        bench: TrialBench,
        state: State,
        memory: Memory,
        again: tuple[Scenario, ...],
        solver: SolverStep,
        start_ns: int,
    ) -> int:
        before = replace(state)
        first = state.tasks + -(-len(again) // self.examples)
        work = Work(self.setup.from_anywhere(), memory.finds.from_anywhere())
        with self._progress(state) as show, noting_ctrl_c() as pressed:

            def news(found: list[Counterexample]) -> None:
                if state.tasks >= first:
                    memory.all_were_run()
                self._keep(bench, state, memory, found)
                show(found)

            try:
                campaign(
                    work if self.dask is None else OwnProcess(work),
                    state,
                    executor_of(self.jobs or 1, self.dask, complain),
                    examples=self.examples,
                    tasks=self.tasks,
                    jobs=self.jobs,
                    again=again,
                    asked=solver,
                    go_on=lambda: not pressed() and self.budget.is_left(state, before, wall_ns() - start_ns),
                    news=news,
                )
            except KeyboardInterrupt:
                interrupted = True
            else:
                interrupted = pressed()
        if interrupted:
            complain(f"stopped by {interrupted_by()}; the same command goes on from here")
            return INTERRUPTED
        return DONE

    def _keep(self, bench: TrialBench, state: State, memory: Memory, found: list[Counterexample]) -> None:
        """Save the state, and write the files of new failures.

        Raises:
            CampaignError: the disk is full; the message has what was found.
            OSError: a file can't be written.
        """
        try:
            for each in found:
                hand_over(self.job, self.setup, bench, each, self._folder_of(state, each.broken))
            write_state(state, self.state_file)
            memory.keep([each.scenario for each in state.kept.entries], state.told)
            state.told.clear()
        except OSError as error:
            if error.errno not in FULL:
                raise
            raise CampaignError(not_kept(error, found, memory.finds.origin)) from error

    def _folder_of(self, state: State, broken: BrokenInvariant) -> Path:
        return self.folder / state.folders[broken.key]

    @contextmanager
    def _progress(self, state: State) -> Iterator[Callable[[list[Counterexample]], None]]:
        """Show the progress of the search on a terminal; yield the function to call after every task."""
        console = Console(file=sys.stderr)  # the real one: a running program may replace it
        if self.quiet or not console.is_terminal:
            yield lambda found: None
            return
        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
        with Progress(*columns, console=console) as bar:
            total = self.tasks if self.budget.wall_ns is None else self.budget.wall_ns
            yield self._bar(bar, bar.add_task("searching", total=total), state)

    def _bar(self, bar: Progress, task: TaskID, state: State) -> Callable[[list[Counterexample]], None]:
        start_ns, tasks_before = wall_ns(), state.tasks

        def show(found: list[Counterexample]) -> None:
            for each in found:
                bar.console.print(on_a_line(str(each.broken)), highlight=False, markup=False)
            timed = self.budget.wall_ns is not None
            done = wall_ns() - start_ns if timed else state.tasks - tasks_before
            text = f"{state.runs:,} runs, {len(state.found)} broken"
            bar.update(task, completed=done, description=text)

        return show
