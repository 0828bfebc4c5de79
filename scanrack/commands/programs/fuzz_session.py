"""A session of `scanrack fuzz`: it repeats known failures, searches, reports, and writes the files."""

from __future__ import annotations

import errno
import shlex
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
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
from .fuzz_options import FuzzOptions
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
"""Maximum and minimum number of scenarios per task, and scans per task (a few seconds).

With an adapter in the rack, a scan takes at least ten times as long.
"""

MOST_COVERED = 60
"""Maximum number of runs on the coverage page; it shows the first runs that reached something new."""

COVERAGE = "coverage.html"
"""File name of the coverage page."""

FULL = (errno.ENOSPC, errno.EDQUOT)
"""Error numbers that mean a full disk."""


@contextmanager
def noting_ctrl_c() -> Iterator[Callable[[], bool]]:
    """Raise KeyboardInterrupt on Ctrl-C; yield a function that returns whether that has happened.

    If the signal is ignored, as in a shell's background, or has another handler, it is left unchanged.
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


@dataclass(slots=True)
class Session:
    """One call of the command."""

    job: LoadedRack
    setup: Setup
    folder: Path
    budget: Budget
    options: FuzzOptions
    base: Scenario | None  # the scenario of a recording; None without a recording
    _bench: TrialBench = field(init=False)
    _state: State = field(init=False)
    _spending: Spending = field(init=False)
    _memory: Memory = field(init=False)
    _solver: SolverStep = field(init=False)

    def __post_init__(self) -> None:
        self._bench = bench_of(self.setup)
        self._state = read_state(self.state_file, relative(self.setup.rack, self.folder))
        self._spending = Spending(self.budget, self._state, self._state.scans)
        origin = Origin.of(self.job, self.setup.scans)
        self._memory = Memory(self.folder, origin, self._bench.spec, complain)
        self._solver = SolverStep(self.job, self._bench)

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
        """Number of tasks; None if only the budget limits it."""
        return -(-self.budget.runs // self._most_examples) if self.budget.is_by_runs else None

    @property
    def _most_examples(self) -> int:
        linked = any(slot.has(Trait.LINE) for slot in self.job.spec.slot)
        return min(MOST_RUNS, max(LEAST_RUNS, (LINKED_SCANS if linked else SCANS) // self.setup.scans))

    def run(self) -> int:
        """Search; return the exit status. The caller must have locked the folder; see `locked`.

        Raises:
            ValueError: an unusable file or option.
            OSError: a file can't be written.
        """
        bench, state, options, tests = self._bench, self._state, self.options, self.options.tests
        for old in state.drop_impossible(bench.spec):
            self._report(
                f"left out: {old.sentence.rstrip('.')} [{old.invariant}]: the program needs newer firmware"
            )
        before = replace(state)
        earlier_scenarios = self._memory.known(tuple(options.begin_with or ()))
        if self.base is not None:
            state.corpus = {RECORDING: self.base, **state.corpus}
        self._repeat_known_failures()
        earlier_scenarios += tuple(self._shrink_remaining())
        self._save(state.note(self._run_undisturbed()))
        status = self._search(earlier_scenarios) if self._can_be_searched() else DONE
        broken = [
            counterexample
            for _, counterexample in sorted(state.found.items())
            if counterexample.broken.invariant in bench.names
        ]
        others = bench.names - {counterexample.broken.invariant for counterexample in broken}
        if status == DONE and tests is not None:
            count = write_tests(tests, self.setup, self.job, self._kept_runs())
            complain(f"{count} tests are written: pytest {shlex.quote(str(tests))}")
        took_s, covered = (wall_ns() - self._spending.begin_ns) / 1e9, ""
        never: list[UnfiredRule] = []
        if status == DONE and options.reports:  # a stopped session has no time for further runs
            with self._spending.on_explaining():
                never, covered = self._write_coverage()
        if options.as_json:
            rows = [
                failure_row(counterexample, self._folder_of(counterexample.broken))
                for counterexample in broken
            ]
            say_json({"broken": rows, **summary_row(state, before, others, bench.goals, never)})
            return self._status(status)
        if not options.quiet:
            lines = [
                summary(state, before, took_s, rules_in(bench.spec.slot)),
                left_over(state, self._spending),
            ]
            lines += [never_fired(never), held(others, state)]
            lines += [*goals(bench.goals, state), covered]
            say("\n".join([*filter(None, lines), closing(self.job, state, self._solver, self.setup.scans)]))
        self._print_failures(broken)
        return self._status(status)

    def _print_failures(self, broken: Sequence[Counterexample]) -> None:
        for counterexample in broken:
            say(f"{failure(counterexample)}\n  see {self._folder_of(counterexample.broken)}")

    def _kept_runs(self) -> list[Scenario]:
        """Return the undisturbed run and the first runs with new coverage."""
        runs = [self.base or Scenario(), *(entry.scenario for entry in self._state.kept.entries)]
        return runs[:MOST_COVERED]

    def _write_coverage(self) -> tuple[list[UnfiredRule], str]:
        """Write the coverage page; return the rules that never fired, and a line for the summary."""
        runs_kept, count, slots = self._kept_runs(), 0, self._bench.spec.slot

        def runs() -> Iterator[Scenario]:
            """Yield and count runs until the time for explanations is over, but at least one."""
            nonlocal count
            for scenario in runs_kept:
                if count and not self._spending.explains:
                    return
                count += 1
                yield scenario

        proved = [
            (site.routine, site.rung, site.instruction, point.state.value)
            for point, site in self._solver.dead_points.items()
        ]
        coverage = coverage_of(self._bench, runs(), self.job, proved)
        oldest = {
            slot.number: Firmware.parse(slot.needs_firmware)
            for slot in slots
            if slot.number in coverage.words
        }
        profile = profile_in(slots, None)
        never = unfired(
            {rule for rule, times in self._state.rules.items() if times}, coverage.words, oldest, profile
        )
        page = self.folder / COVERAGE
        partly = (
            f" in {count} of {len(runs_kept)} runs, since the time is over" if count < len(runs_kept) else ""
        )
        title, rules = f"Coverage of {self.job.program.name}", len(error_rules(profile))
        save_coverage(page, title, coverage.lines, runs=count, never=never, rules=rules)
        return never, f"coverage      {coverage_line(coverage.lines)}{partly}, see {page}"

    def _status(self, status: int) -> int:
        """Return the exit status for an error, a broken invariant or an unseen goal, in this order."""
        if status:
            return status
        if any(example.broken.invariant in self._bench.names for example in self._state.found.values()):
            return NO
        is_unseen = any(goal.name not in self._state.applied for goal in self._bench.goals)
        return NOT_SEEN if self.options.strict and is_unseen else DONE

    def _run_undisturbed(self) -> list[Counterexample]:
        """Run the program without disturbances; report values that may differ between identical runs."""
        uses = NondeterminismSources()
        failures = undisturbed(
            uses.recording_bench(self._bench),
            self.base or Scenario(),
            self._state.found,
            confirm=Confirmation(self.setup),
        )
        if uses.seen:
            complain(f"the program uses {uses}: results may differ between identical runs")
        return failures

    def _report(self, text: str) -> None:
        say(text, err=self.options.as_json)

    def _repeat_known_failures(self) -> None:
        """Repeat known failures, and report the fixed ones."""
        for broken in self._state.recheck(self._bench):
            self._report(f"fixed: {broken.sentence.rstrip('.')} [{broken.invariant}]")
            note_fixed(self._folder_of(broken) / "report.txt")

    def _can_be_searched(self) -> bool:
        """Return whether the program can be searched; if not, report why."""
        faults = [
            counterexample
            for counterexample in self._state.found.values()
            if counterexample.broken.invariant == NO_FAULT
        ]
        if any(not fault.scenario.size for fault in faults):
            complain("the program faults without random disturbances: fix this before a search")
            return False
        return True

    def _shrink_remaining(self) -> Iterator[Scenario]:
        """Shrink the failures left over from a killed session; yield the scenarios that no longer fail."""
        for file, recipe in self._memory.unshrunk_failures():
            if recipe.broken and recipe.broken not in self._bench.names:
                continue  # this session does not have the invariant
            failures = undisturbed(
                self._bench,
                recipe.scenario,
                self._state.found,
                confirm=Confirmation(self.setup),
                has_time=lambda: self._spending.searches,
            )
            if not failures and recipe.origin.scans > self.setup.scans:
                continue  # it needs a longer run than the runs of this session
            self._save(self._state.note(failures))
            file.unlink(missing_ok=True)
            if not failures:
                yield recipe.scenario

    def _search(self, again: tuple[Scenario, ...]) -> int:
        """Search until the budget is spent or Ctrl-C is pressed; return the status.

        The scenarios in `again` are run first.
        """
        state, memory, spending = self._state, self._memory, self._spending
        tasks_until_new = state.tasks + -(-len(again) // self.examples)
        work = Work(self.setup.with_absolute_paths(), memory.finds.with_absolute_paths())
        jobs, dask = self.options.tasks_at_a_time, self.options.dask
        with self._progress() as show, noting_ctrl_c() as was_pressed:

            def news(failures: list[Counterexample]) -> None:
                """Show and save the new failures of a task, if any."""
                if state.tasks >= tasks_until_new:
                    memory.all_were_run()
                show(failures)
                self._save(failures)

            try:
                campaign(
                    work if dask is None else OwnProcess(work),
                    state,
                    executor_of(jobs or 1, dask, complain),
                    examples=self.examples,
                    tasks=self.tasks,
                    jobs=jobs,
                    again=again,
                    suggest=self._solver,
                    has_time=lambda: not was_pressed() and spending.searches,
                    allowance=lambda: spending.allowance(jobs or 1),
                    news=news,
                )
            except KeyboardInterrupt:
                interrupted = True
            else:
                interrupted = was_pressed()
        if interrupted:
            complain(f"stopped by {interrupted_by()}; run the same command to continue")
            return INTERRUPTED
        return DONE

    def _save(self, failures: list[Counterexample]) -> None:
        """Save the state, and write the files of new failures.

        Raises:
            CampaignError: the disk is full; the message contains the new failures.
            OSError: a file can't be written.
        """
        try:
            for counterexample in failures:
                folder = self._folder_of(counterexample.broken)
                with self._spending.on_explaining():
                    explained = write_failure(
                        self.job,
                        self.setup,
                        self._bench,
                        counterexample,
                        folder,
                        has_time=lambda: self._spending.explains,
                    )
                self._spending.not_explained += not explained
            write_state(self._state, self.state_file)
            self._memory.keep(
                [entry.scenario for entry in self._state.kept.entries], self._state.unshrunk_found
            )
            self._state.unshrunk_found.clear()
        except OSError as error:
            if error.errno not in FULL:
                raise
            raise CampaignError(not_kept(error, failures, self._memory.finds.origin)) from error

    def _folder_of(self, broken: BrokenInvariant) -> Path:
        return self.folder / self._state.folders[broken.key]

    @contextmanager
    def _progress(self) -> Iterator[Callable[[list[Counterexample]], None]]:
        """Show the progress of the search on a terminal; yield the function to call after every task."""
        console = Console(file=sys.stderr)  # a running program may replace `sys.stderr`
        if self.options.quiet or not console.is_terminal:
            yield lambda found: None
            return
        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
        with Progress(*columns, console=console) as bar:
            total = self.tasks if self._spending.share is None else 1.0
            yield self._bar(bar, bar.add_task("searching", total=total))

    def _bar(self, bar: Progress, task: TaskID) -> Callable[[list[Counterexample]], None]:
        """Return a function that prints the new failures of a task, and updates the bar."""
        state = self._state
        tasks_before = state.tasks

        def show(failures: list[Counterexample]) -> None:
            for counterexample in failures:
                bar.console.print(on_a_line(str(counterexample.broken)), highlight=False, markup=False)
            share = self._spending.share
            text = f"{state.runs:,} runs, {len(state.found)} broken"
            text += f", explaining {failures[0].broken.invariant}" if failures else ""
            bar.update(
                task, completed=state.tasks - tasks_before if share is None else share, description=text
            )

        return show
