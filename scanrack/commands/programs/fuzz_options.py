"""The options of `scanrack fuzz`."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from scanrack.jobs.fuzz import STANDARD
from scanrack.jobs.fuzz.scenarios.kinds import Kind
from scanrack.terminal.as_json import JsonOption
from scanrack.terminal.shared_options import TrustOption


@dataclass(frozen=True, slots=True, kw_only=True)
class FuzzOptions:
    """The argument and the options of `scanrack fuzz`."""

    rack: Annotated[
        str,
        typer.Argument(
            metavar="RACK", help="Rack file (TOML, or Python that defines rack()), or a trace to vary."
        ),
    ]
    invariants: Annotated[
        list[Path] | None,
        typer.Option("--invariants", "-i", metavar="FILE", help="Python file with invariants."),
    ] = None
    check: Annotated[
        list[str] | None,
        typer.Option("--check", metavar="NAME", help=f"Built-in invariant: {', '.join(STANDARD)}."),
    ] = None
    duration: Annotated[
        str | None, typer.Option("--for", metavar="TIME", help="Machine time of a run, such as '10 s'.")
    ] = None
    runs: Annotated[
        int,
        typer.Option(
            "--runs",
            metavar="N",
            min=1,
            help="Number of scenarios to try, without shrinking and the corpus.",
        ),
    ] = 500
    time: Annotated[
        str | None,
        typer.Option("--budget", metavar="TIME", help="Search for this time instead, such as '2 h'."),
    ] = None
    scans: Annotated[
        int | None,
        typer.Option("--scans", metavar="N", min=1, help="Search for this number of scans instead."),
    ] = None
    processor: Annotated[
        str | None,
        typer.Option("--processor", metavar="TIME", help="Search for this processor time instead."),
    ] = None
    only: Annotated[
        list[str] | None,
        typer.Option(
            "--only", metavar="KIND", help=f"Random kinds: {', '.join(kind.value for kind in Kind)}."
        ),
    ] = None
    without: Annotated[
        list[str] | None, typer.Option("--without", metavar="KIND", help="Kinds that are not random.")
    ] = None
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", "-j", metavar="N", min=1, help="Parallel tasks.", show_default="cores"),
    ] = None
    dask: Annotated[
        str | None, typer.Option("--dask", metavar="ADDRESS", help="Search on a Dask cluster.")
    ] = None
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="FOLDER", help="Folder of the campaign.", show_default="RACK-fuzz"
        ),
    ] = None
    begin_with: Annotated[
        list[Path] | None,
        typer.Option(
            "--corpus", metavar="PATH", help="Start from the corpus in another folder, or from a recording."
        ),
    ] = None
    scenario: Annotated[
        Path | None, typer.Option("--scenario", metavar="FILE", help="Run only this scenario.")
    ] = None
    tests: Annotated[
        Path | None,
        typer.Option(
            "--write-tests",
            metavar="FOLDER",
            help="Write pytest tests that cover the same parts of the program.",
        ),
    ] = None
    trust: TrustOption = False
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit status 3 if a condition of @sometimes was never true.")
    ] = False
    as_json: JsonOption = False
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar and no summary.")] = False

    @property
    def tasks_at_a_time(self) -> int | None:
        """Number of concurrent tasks; None if a cluster chooses it."""
        return self.jobs or (None if self.dask is not None else os.cpu_count() or 1)

    @property
    def reports(self) -> bool:
        """Whether to print a summary."""
        return self.as_json or not self.quiet
