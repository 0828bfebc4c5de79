"""Reports, trials, rack files, differences and copies of controller exports."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from scanrack.jobs.imports.export_start import DOWNLOADED, ExportStart
from scanrack.jobs.load.exports import start_of_export
from scanrack.jobs.load.trial import Trial, is_slc, tried
from scanrack.ladder.files.rungfile import read_program
from scanrack.ladder.files.suffixes import SUFFIX
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.stubs import Stubs
from scanrack.rockwell.diff import compare_exports, page_of, text_of_export
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.export import export_l5x
from scanrack.rockwell.l5x.partial import partial_l5x
from scanrack.rockwell.l5x.trial import SCANS
from scanrack.rockwell.l5x.xml.document import checked_bytes, read_bytes
from scanrack.rockwell.slc import import_slc
from scanrack.rockwell.slc.document import read_document as read_slc
from scanrack.terminal.as_json import say_json
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.status import BAD_INPUT, CANNOT_WRITE, DONE, NO, complain, reason, size_of
from scanrack.terminal.terminal import say, say_file
from scanrack.traces.files.guard import EXPORT, PAGE
from scanrack.traces.files.newfile import new_file

from .l5x_options import L5xOptions

if TYPE_CHECKING:
    from scanrack.jobs.first.first_run import FirstRun
    from scanrack.rockwell.l5x import L5xImport
    from scanrack.rockwell.l5x.report import Report
    from scanrack.rockwell.slc import SlcImport


def l5x(file: Path, options: L5xOptions) -> None:
    """Report the imported, refused and running parts of an L5X or SLC export, or print another output.

    Raises:
        typer.Exit: always, with the status of the command.
    """
    start = start_of_export(keep_values=options.keep_values, memory=options.memory) or DOWNLOADED
    if file.is_dir():
        raise typer.Exit(_report_folder(file, options, start))
    if (status := _print_other_output(file, options, start)) is not None:
        raise typer.Exit(status)
    imported = _try_export(file, options, start)
    first = _first_run(file, imported, options.scans, start) if options.run else None
    _print_report(imported.report, first, as_json=options.as_json)
    is_clean = first is None or not (first.fault or first.problem)
    raise typer.Exit(DONE if imported.report.complete and is_clean else NO)


def _try_export(file: Path, options: L5xOptions, start: ExportStart) -> L5xImport | SlcImport:
    """Import an export and run a trial of its program; exit if the export can't be used."""
    try:
        scans = (not options.run and options.scans) or SCANS
        return tried(file, Trial(scans, options.stand_in, start.memory_mib))
    except LadderError as error:
        if options.as_json:
            say_json({"file": str(file), "problem": str(error)})
        raise typer.Exit(complain(str(error), BAD_INPUT)) from None


def _print_report(report: Report, first: FirstRun | None, *, as_json: bool) -> None:
    """Print the report of an export, and of its first run."""
    if as_json:
        say_json(report.as_json() | ({} if first is None else {"run": first.as_json()}))
        return
    for line in (*report.lines(), *(() if first is None else first.lines())):
        say(line)


def _report_folder(folder: Path, options: L5xOptions, start: ExportStart) -> int:
    """Report on all exports in a folder; return the exit status."""
    of_one = replace(options, as_json=False, scans=None, stand_in=False, memory=None)
    if of_one != L5xOptions():
        return complain(f"{folder}: a folder takes --json, --scans, --stand-in and --memory", BAD_INPUT)
    from .l5x_folder import l5x_folder  # a single file does not need this

    trial = Trial(options.scans or SCANS, options.stand_in, start.memory_mib)
    return l5x_folder(folder, trial, as_json=options.as_json)


def _print_other_output(file: Path, options: L5xOptions, start: ExportStart) -> int | None:
    """Print or write the output that replaces the report; return the exit status, or None for a report."""
    with reported_mistakes():
        if options.html is not None and options.against is None:
            raise ValueError("--html needs --against OLDER")
        if options.against is not None:
            return _print_differences(file, options.against, options.html, as_json=options.as_json)
        if options.text:
            say(text_of_export(file), whole=True)
            return DONE
        if options.rack or options.stepper:
            return _print_rack(file, options.stepper or [], start, stand_in=options.stand_in)
    if options.export is not None or options.out is not None:
        return _export(file, options.export, options.out)
    return None


def _first_run(
    file: Path, imported: L5xImport | SlcImport, scans: int | None, start: ExportStart
) -> FirstRun:
    """Run an export on its own rack."""
    from scanrack.jobs.first import first_run  # racks take time to import, and a report needs none

    return first_run.first_run(file, imported, scans or first_run.SCANS, start)


def _print_differences(file: Path, older: Path, html: Path | None, *, as_json: bool) -> int:
    """Print the differences between two versions, and draw them; return the exit status."""
    comparison = compare_exports(older, file)
    if html is not None:
        with new_file(html, PAGE, used={file: "the export", older: "the older export"}) as out:
            out.write(page_of(comparison, older.name, file.name))
    if as_json:
        say_json({"file": str(file), "against": str(older), **comparison.as_json()})
    else:
        for line in comparison.lines():
            say(line)
    return NO if comparison.differences else DONE


def _export(file: Path, name: str | None, out: Path | None) -> int:
    """Print or write a program or a routine as an L5X, or the whole file; return the exit status."""
    try:
        data = _exported(file, name)
        if out is None:
            say_file(data)
            return DONE
        with new_file(out, EXPORT, "wb", used={file: "the export that is read"}) as opened:
            opened.write(data)
    except OSError as error:
        return complain(reason(error), BAD_INPUT if out is None else CANNOT_WRITE)
    except ValueError as error:
        return complain(str(error), BAD_INPUT)
    say(f"{out}: {size_of(out)}{'' if name else f', identical to {file}'}")
    return DONE


def _exported(file: Path, name: str | None) -> bytes:
    """Return a copy of an export or of part of it; for a rung file, return a new L5X."""
    if file.suffix == SUFFIX:
        if name is None:
            raise LadderError(f"{file}: not an export; choose a program with --export")
        return export_l5x(read_program(file), name)
    if not is_slc(file):
        return checked_bytes(file) if name is None else partial_l5x(read_bytes(file), name, str(file))
    if name is not None:
        raise LadderError(f"{file}: --export prints parts of an L5X or a {SUFFIX} file; --out copies an SLC")
    return read_slc(file).source


def _print_rack(file: Path, steppers: list[str], start: ExportStart, *, stand_in: bool) -> int:
    """Print a rack file for an export; return the exit status."""
    from scanrack.jobs.imports.l5x_rack import rack_of  # racks take time to import, and a report needs none
    from scanrack.jobs.imports.slc_rack import rack_of_slc

    if is_slc(file):
        program = import_slc(file)
        printed, report = rack_of_slc(program, file, steppers), program.report
    else:
        stubs = Stubs(missing_tags=stand_in)
        imported = import_l5x(file, stubs, trial=True, memory_mib=start.memory_mib)
        printed, report = rack_of(imported, file, steppers, export=start), imported.report
    say(printed.rstrip(), whole=True)
    return DONE if report.complete else NO
