"""`scanrack prove RACK`: prove properties of a ladder program, or refute them with scenarios."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from scanrack.io_images.installing import how_to_install
from scanrack.jobs.load.program import split_address
from scanrack.jobs.prove.checking import Solver
from scanrack.jobs.prove.checking import solvers as find_solvers
from scanrack.jobs.prove.differing import as_json as edited_as_json
from scanrack.jobs.prove.differing import edited, lines_of
from scanrack.jobs.prove.page import parts_of, parts_of_edit, save_page
from scanrack.jobs.prove.proving import (
    AnswerListener,
    FoundAnswer,
    Questions,
    Result,
    ScenarioFolder,
    ask_questions,
    no_progress,
    prove_all,
)
from scanrack.jobs.prove.report import as_json as json_of
from scanrack.jobs.prove.report import assumptions, below, found_lines, line_of, open_text, questions_text
from scanrack.jobs.prove.subject import ProofSubject, subject_of
from scanrack.jobs.trust.owned import in_use
from scanrack.ladder.prove.answers import LIMITS
from scanrack.ladder.prove.induction import VerdictKind
from scanrack.ladder.prove.questions import Question
from scanrack.ladder.prove.solving.solver import SolverMissingError
from scanrack.terminal.as_json import JsonOption, say_json
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.grouped import grouped
from scanrack.terminal.status import BAD_INPUT, DONE, NO, complain
from scanrack.terminal.terminal import say

_COMMA = re.compile(r",(?![^\[]*\])")
"""A comma that is not in a subscript."""

UNDECIDED = 3
"""Exit status if no property is refuted and at least one is unknown."""


@dataclass(frozen=True)
class ComparedTags:
    """The compared tags of two programs, and the tags that may differ."""

    only: Annotated[
        str | None,
        typer.Option(
            "--may-differ", metavar="TAGS", help="Two programs: tags that may differ, separated by commas."
        ),
    ] = None
    outputs: Annotated[
        str | None,
        typer.Option(
            "--outputs", metavar="TAGS", help="Two programs: compare only these tags, separated by commas."
        ),
    ] = None

    @property
    def option(self) -> str:
        """The option that was given; "" if there was none."""
        if self.only is not None:
            return "--may-differ"
        return "--outputs" if self.outputs is not None else ""


def _prove_command(
    rack: Annotated[
        str, typer.Argument(metavar="RACK", help="Rack file (TOML or Python), ladder program or export.")
    ],
    compared: ComparedTags,
    new: Annotated[
        str | None,
        typer.Argument(metavar="[NEW]", help="Second program: only list possible differences."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FOLDER", help="Folder of scenarios.", show_default="RACK-prove"),
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(
            "--html", metavar="FILE", help="Also write a page that draws the rungs of each scenario."
        ),
    ] = None,
    check: Annotated[
        bool,
        typer.Option("--check", help="Check each proof with the other solvers that are installed: z3, cvc5."),
    ] = False,
    work: Annotated[
        int,
        typer.Option("--work", metavar="N", min=1, max=1000, help="Multiply the limits, to decide more."),
    ] = 1,
    as_json: JsonOption = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Prove properties or find counterexamples: for every input, scan time in a range and number of scans.

    Properties are in the rack file ([[prove.property]]), in comments (prove: never Fwd AND Rev) and in a
    routine NEVER. Each property is proved, or refuted with a scenario that was replayed with the program and
    the rack, or unknown because of an instruction or a limit. Built-in questions follow: rungs that are never
    true, contacts that decide nothing, coils that are never on or never off again, coils that disagree,
    timers that are never done, faults, endless loops. The assumptions of the proofs are at the end. Each
    proof has a certificate, proof.smt2 and proof.json. With --check, other solvers check it; a property whose
    certificate is refused is unknown.

    For two programs, it compares each bit and number that either program writes. It lists the values that can
    differ in one scan or in any run, each with a run and the inputs on which the difference depends. All
    other values are equal. With --may-differ, it fails if another value can differ.

    Examples:
        scanrack new feeder --from feeder
        scanrack prove feeder/feeder.toml
        scanrack prove before.L5X after.L5X --may-differ Valve1,Valve2

    Exit status: 0 all proved, 1 a property is refuted, or a run faults or has coils that disagree, 2 a file
    can't be used, 3 a property is unknown (and none is refuted), or a file can't be written. For two
    programs: 0 equal, except for --may-differ, 1 another value can differ.
    """
    with reported_mistakes():
        try:
            if new is not None:
                raise typer.Exit(_compare(rack, new, compared, out, html, as_json=as_json))
            if option := compared.option:
                raise ValueError(f"{option} needs two programs: scanrack prove OLD NEW {option} TAGS")
            solvers = _installed_solvers() if check else []
            subject = subject_of(rack)
            with ScenarioFolder(out or Path(f"{subject.name}-prove")) as folder:
                progress = _progress if _is_shown(quiet=quiet) else no_progress
                results = []
                for result in prove_all(subject, folder, progress, LIMITS.times(work), solvers):
                    if not as_json:
                        _say_result(subject, result)
                    results.append(result)
                listener = AnswerListener() if as_json else _Printing(quiet=quiet)
                answers = ask_questions(subject, folder, solvers, listener, work)
                if html is not None:
                    files_in_use = in_use(subject.job)
                    save_page(html, f"proofs about {rack}", parts_of(subject, results, answers), files_in_use)
        except SolverMissingError as error:
            raise typer.Exit(complain(str(error), BAD_INPUT)) from error
    if as_json:
        say_json(json_of(subject, results, answers))
    else:
        _say_rest(subject, results, answers)
    raise typer.Exit(status_of(results, answers))


def _tags(text: str | None) -> list[str]:
    return [name.strip() for name in _COMMA.split(text or "") if name.strip()]


def _compare(
    old: str,
    new: str,
    compared: ComparedTags,
    out: Path | None,
    html: Path | None,
    *,
    as_json: bool,
) -> int:
    """Print the values that can differ between two programs; return the exit status."""
    with ScenarioFolder(out or Path(f"{Path(split_address(new)[0]).stem}-prove")) as folder:
        comparison = edited(old, new, _tags(compared.outputs), _tags(compared.only), folder)
    if html is not None:
        files_in_use = {Path(split_address(address)[0]): "one of the programs" for address in (old, new)}
        save_page(html, f"{old} and {new}", parts_of_edit(comparison), files_in_use)
    if as_json:
        say_json(edited_as_json(comparison))
    else:
        for line in lines_of(comparison):
            say(line)
    return DONE if comparison.is_equal else NO


def _installed_solvers() -> list[Solver]:
    """Return the installed solvers that can check proofs; raise ValueError if there are none."""
    installed = find_solvers()
    if not installed:
        raise ValueError(
            f"--check needs another solver, z3 or cvc5: {how_to_install('check')}, or a program on the PATH"
        )
    return installed


def _say_result(subject: ProofSubject, result: Result) -> None:
    """Print the result of a property."""
    say(line_of(result, max(len(claim.claim.name) for claim in subject.program.properties)))
    for line in below(subject, result):
        say(f"    {line}")


def _is_shown(*, quiet: bool) -> bool:
    return not quiet and sys.stderr.isatty()


def _progress(name: str, number: int, total: int) -> None:
    say(f"proving {number} of {total}: {name}", err=True)


class _Printing(AnswerListener):
    """Progress output that prints each finding immediately."""

    def __init__(self, *, quiet: bool) -> None:
        self._quiet = quiet

    def begun(self, count: int) -> None:
        """Print the number of questions."""
        if count:
            say(questions_text(count))

    def found(self, answer: FoundAnswer) -> None:
        """Print a finding."""
        for line in found_lines(answer):
            say(line)

    def left(self, count: int) -> None:
        """Print the number of remaining questions."""
        if not self._quiet:
            say(f"proving: {count:,} questions remain", err=True)

    def next(self, question: Question, count: int) -> None:
        """Print the next remaining question."""
        if _is_shown(quiet=self._quiet):
            say(f"proving, {count:,} after it: {question.site.where}: {question.text}", err=True)


def _say_rest(subject: ProofSubject, results: Sequence[Result], answers: Questions) -> None:
    """Print the undecided questions, a hint if there are no properties, and the assumptions."""
    if open_questions := open_text(answers):
        say(open_questions)
    if not results:
        say("no properties: a rack file has [[prove.property]], a rung's comment prove: never CONDITION")
    say("assumed:")
    for assumption in assumptions(subject, results):
        say(f"    {assumption}")


def status_of(results: Sequence[Result], answers: Questions) -> int:
    """Return the exit status; open built-in questions do not affect it."""
    words = {result.word for result in results}
    if VerdictKind.REFUTED in words or any(answer.refuted for answer in answers.found):
        return NO
    return UNDECIDED if VerdictKind.UNKNOWN in words else DONE


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("prove", no_args_is_help=True)(grouped(_prove_command, compared=ComparedTags))
