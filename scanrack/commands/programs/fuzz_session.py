"""A session of `scanrack fuzz`: confirm known failures, search, report, write the files."""

from __future__ import annotations

import errno
import shlex
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from signal import default_int_handler
from threading import current_thread, main_thread
from types import FrameType

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TaskProgressColumn, TextColumn, TimeElapsedColumn
from scanrack.io_images.amci3601 import Firmware
from scanrack.jobs.fuzz import Counterexample, Scenario, undisturbed
from scanrack.jobs.fuzz.campaign.campaign import campaign
from scanrack.jobs.fuzz.campaign.confirming import Confirmation
from scanrack.jobs.fuzz.campaign.executors import executor_of
from scanrack.jobs.fuzz.campaign.memory import Memory
from scanrack.jobs.fuzz.campaign.recipes import Origin
from scanrack.jobs.fuzz.campaign.state import RECORDING, CampaignError, State, read_state, write_state
from scanrack.jobs.fuzz.campaign.working import OwnProcess, Work
from scanrack.jobs.fuzz.explain.coverage import coverage_of
from scanrack.jobs.fuzz.explain.coverage_page import coverage_line, save_coverage
from scanrack.jobs.fuzz.explain.unfired import UnfiredRule, error_rules, rules_in, unfired
from scanrack.jobs.fuzz.folder_lock import STATE_NAME
from scanrack.jobs.fuzz.job import Setup, bench_of, write_failure
from scanrack.jobs.fuzz.nondeterminism import NondeterminismSources
from scanrack.jobs.fuzz.report import note_fixed
from scanrack.jobs.fuzz.run import NO_FAULT, BrokenInvariant, TrialBench
from scanrack.jobs.fuzz.written_tests import write_tests
from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.prove.serving.stuck import SolverStep
from scanrack.runtime.config.rackspec import profile_in
from scanrack.runtime.loop.pace import interrupted_by, wall_ns
from scanrack.runtime.modules.record import Trait
from scanrack.terminal.as_json import say_json
from scanrack.terminal.status import DONE, INTERRUPTED, NO, NOT_SEEN, complain
from scanrack.terminal.terminal import on_a_line, say
from scanrack.traces.files.portable import relative

from .fuzz_budget import Budget, Spending
from .fuzz_summary import (
    closing,
    failure,
    failure_row,
    goals,
    held,
    left_over,
    never_fired,
    not_kept,
    summary,
    summary_row,
)

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
class Session:
    """The options of one call of the command."""

    job: LoadedRack
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
    tests: Path | None = None  # a new folder for tests of what was reached, or None

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
        linked = any(slot.has(Trait.LINE) for slot in self.job.spec.slot)
        return min(MOST_RUNS, max(LEAST_RUNS, (LINKED_SCANS if linked else SCANS) // self.setup.scans))

    def run(self) -> int:
        """Search; return the exit status. The caller holds the folder, see `locked`.

        Raises:
            ValueError: an unusable file or option.
            OSError: a file can't be written.
        """
        bench = bench_of(self.setup)
        state = read_state(self.state_file, relative(self.setup.rack, self.folder))
        for old in state.drop_impossible(bench.spec):
            self._tell(
                f"left out: {old.sentence.rstrip('.')} [{old.invariant}]: the program needs newer firmware"
            )
        before = replace(state)
        spending = Spending(self.budget, state, state.scans)
        memory = Memory(self.folder, Origin.of(self.job, self.setup.scans), bench.spec, complain)
        again = memory.known(self.begin_with)
        if self.base is not None:
            state.corpus = {RECORDING: self.base, **state.corpus}
        self._look_again(bench, state)
        again += tuple(self._shrink_what_is_left(bench, state, memory, spending))
        self._keep(bench, state, memory, state.note(self._undisturbed(bench, state)), spending)
        status = DONE
        solver = SolverStep(self.job, bench)
        if self._can_be_searched(state):
            status = self._search(bench, state, memory, again, solver, spending)
        broken = [each for _, each in sorted(state.found.items()) if each.broken.invariant in bench.names]
        others = bench.names - {each.broken.invariant for each in broken}
        if status == DONE and self.tests is not None:
            count = write_tests(self.tests, self.setup, self.job, self._kept_runs(state))
            complain(f"{count} tests are written: pytest {shlex.quote(str(self.tests))}")
        took_s, covered = (wall_ns() - spending.begin_ns) / 1e9, ""
        never: list[UnfiredRule] = []
        is_reported = self.as_json or not self.quiet
        if status == DONE and is_reported:  # not of one that was stopped: it takes some runs
            with spending.on_explaining():
                never, covered = self._cover(bench, state, solver, spending)
        if self.as_json:
            rows = [failure_row(each, self._folder_of(state, each.broken)) for each in broken]
            say_json({"broken": rows, **summary_row(state, before, others, bench.goals, never)})
            return self._status(status, bench, state)
        if not self.quiet:
            lines = [
                summary(state, before, took_s, rules_in(bench.spec.slot)),
                left_over(state, spending),
            ]
            lines += [never_fired(never), held(others, state)]
            lines += [*goals(bench.goals, state), covered]
            say("\n".join([*filter(None, lines), closing(self.job, state, solver, self.setup.scans)]))
        self._print_failures(state, broken)
        return self._status(status, bench, state)

    def _print_failures(self, state: State, broken: Sequence[Counterexample]) -> None:
        for each in broken:
            say(f"{failure(each)}\n  see {self._folder_of(state, each.broken)}")

    def _kept_runs(self, state: State) -> list[Scenario]:
        """Return the undisturbed run, and the first ones that showed something new."""
        return [self.base or Scenario(), *(each.scenario for each in state.kept.entries)][:MOST_COVERED]

    def _cover(
        self, bench: TrialBench, state: State, solver: SolverStep, spending: Spending
    ) -> tuple[list[UnfiredRule], str]:
        """Write the page of coverage; return the rules that never fired, and its line of the summary."""
        kept, count = self._kept_runs(state), 0

        def runs() -> Iterator[Scenario]:
            nonlocal count
            for each in kept:
                if count and not spending.explains:
                    return
                count += 1
                yield each

        proved = [
            (site.routine, site.rung, site.instruction, point.state.value)
            for point, site in solver.dead_points.items()
        ]
        went = coverage_of(bench, runs(), self.job, proved)
        oldest = {
            slot.number: Firmware.parse(slot.needs_firmware)
            for slot in bench.spec.slot
            if slot.number in went.given
        }
        profile = profile_in(bench.spec.slot, None)
        never = unfired({rule for rule, count in state.rules.items() if count}, went.given, oldest, profile)
        page = self.folder / COVERAGE
        partly = f" in {count} of {len(kept)} runs, for the time is over" if count < len(kept) else ""
        title, rules = f"Coverage of {self.job.program.name}", len(error_rules(profile))
        save_coverage(page, title, went.lines, count, never, rules)
        return never, f"coverage      {coverage_line(went.lines)}{partly}, see {page}"

    def _status(self, status: int, bench: TrialBench, state: State) -> int:
        """Return the exit status: what went wrong before what is broken, before what was never seen."""
        broken = any(each.broken.invariant in bench.names for each in state.found.values())
        unseen = self.strict and any(each.name not in state.applied for each in bench.goals)
        return status or (NO if broken else NOT_SEEN if unseen else DONE)

    def _undisturbed(self, bench: TrialBench, state: State) -> list[Counterexample]:
        """Run the program without disturbances; report its use of values that may differ between runs."""
        uses = NondeterminismSources()
        found = undisturbed(
            uses.watching(bench), self.base or Scenario(), state.found, confirm=Confirmation(self.setup)
        )
        if uses.seen:
            complain(f"the program uses {uses}: results may differ between identical runs")
        return found

    def _tell(self, text: str) -> None:
        say(text, err=self.as_json)

    def _look_again(self, bench: TrialBench, state: State) -> None:
        """Repeat known failures, and report those that are gone."""
        for broken in state.recheck(bench):
            self._tell(f"fixed: {broken.sentence.rstrip('.')} [{broken.invariant}]")
            note_fixed(self._folder_of(state, broken) / "report.txt")

    def _can_be_searched(self, state: State) -> bool:
        """Return whether the program can be searched; if not, report why."""
        faults = [each for each in state.found.values() if each.broken.invariant == NO_FAULT]
        if any(not each.scenario.size for each in faults):
            complain("the program faults with nothing random around it: fix that, then search")
            return False
        return True

    def _shrink_what_is_left(
        self, bench: TrialBench, state: State, memory: Memory, spending: Spending
    ) -> Iterator[Scenario]:
        """Shrink what an earlier session has found before it was killed; yield what holds now."""
        for file, recipe in memory.left():
            if recipe.broken and recipe.broken not in bench.names:
                continue  # of an invariant that this session does not have
            found = undisturbed(
                bench,
                recipe.scenario,
                state.found,
                confirm=Confirmation(self.setup),
                has_time=lambda: spending.searches,
            )
            if not found and recipe.origin.scans > self.setup.scans:
                continue  # its run is longer than those of this session
            self._keep(bench, state, memory, state.note(found), spending)
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
        spending: Spending,
    ) -> int:
        first = state.tasks + -(-len(again) // self.examples)
        work = Work(self.setup.with_absolute_paths(), memory.finds.with_absolute_paths())
        with self._progress(state, spending) as show, noting_ctrl_c() as pressed:

            def news(found: list[Counterexample]) -> None:
                if state.tasks >= first:
                    memory.all_were_run()
                show(found)
                self._keep(bench, state, memory, found, spending)

            try:
                campaign(
                    work if self.dask is None else OwnProcess(work),
                    state,
                    executor_of(self.jobs or 1, self.dask, complain),
                    examples=self.examples,
                    tasks=self.tasks,
                    jobs=self.jobs,
                    again=again,
                    suggest=solver,
                    has_time=lambda: not pressed() and spending.searches,
                    allowance=lambda: spending.allowance(self.jobs or 1),
                    news=news,
                )
            except KeyboardInterrupt:
                interrupted = True
            else:
                interrupted = pressed()
        if interrupted:
            complain(f"stopped by {interrupted_by()}; run the same command to continue")
            return INTERRUPTED
        return DONE

    def _keep(
        self,
        bench: TrialBench,
        state: State,
        memory: Memory,
        found: list[Counterexample],
        spending: Spending,
    ) -> None:
        """Save the state, and write the files of new failures.

        Raises:
            CampaignError: the disk is full; the message has what was found.
            OSError: a file can't be written.
        """
        try:
            for each in found:
                folder = self._folder_of(state, each.broken)
                with spending.on_explaining():
                    explained = write_failure(
                        self.job, self.setup, bench, each, folder, lambda: spending.explains
                    )
                spending.not_explained += not explained
            write_state(state, self.state_file)
            memory.keep([each.scenario for each in state.kept.entries], state.unshrunk_found)
            state.unshrunk_found.clear()
        except OSError as error:
            if error.errno not in FULL:
                raise
            raise CampaignError(not_kept(error, found, memory.finds.origin)) from error

    def _folder_of(self, state: State, broken: BrokenInvariant) -> Path:
        return self.folder / state.folders[broken.key]

    @contextmanager
    def _progress(self, state: State, spending: Spending) -> Iterator[Callable[[list[Counterexample]], None]]:
        """Show the progress of the search on a terminal; yield the function to call after every task."""
        console = Console(file=sys.stderr)  # the real one: a running program may replace it
        if self.quiet or not console.is_terminal:
            yield lambda found: None
            return
        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
        with Progress(*columns, console=console) as bar:
            total = self.tasks if spending.share is None else 1.0
            yield self._bar(bar, bar.add_task("searching", total=total), state, spending)

    def _bar(
        self, bar: Progress, task: TaskID, state: State, spending: Spending
    ) -> Callable[[list[Counterexample]], None]:
        tasks_before = state.tasks

        def show(found: list[Counterexample]) -> None:
            for each in found:
                bar.console.print(on_a_line(str(each.broken)), highlight=False, markup=False)
            share = spending.share
            text = f"{state.runs:,} runs, {len(state.found)} broken"
            text += f", explaining {found[0].broken.invariant}" if found else ""
            bar.update(
                task, completed=state.tasks - tasks_before if share is None else share, description=text
            )

        return show
