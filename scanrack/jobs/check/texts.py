"""Checks the files of an editor, including unsaved changes: the problems in each file, with their lines.

    line.rung, line.st    read, built, and checked with a rack file in the folder that names it, or alone
    test_line.rung, .st   with the header of test routines: built with the program of their rack
    line.steps            read
    line.toml             read, and checked with its program
    line.py               compiled; checked with its rack if it may be run

A check of a Python program imports its module, which runs code. Without permission, no Python runs at all:
not the file, the program of a rack file, a stub, or anything that a neighboring rack names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from scanrack.io_images.input_files import read_input_text, unsaved
from scanrack.io_images.site import Site, SiteError
from scanrack.io_images.text_limits import TextKind
from scanrack.ladder.files.suffixes import STEPS_SUFFIX, STRUCTURED_SUFFIX, SUFFIX
from scanrack.ladder.files.testfile import read_test_file
from scanrack.ladder.model.errors import BuildError
from scanrack.runtime.config.rackfile import RackFileError, load_rack_file, parse_toml
from scanrack.runtime.config.rackspec import RackSpec

from ..load.program import is_python, load_program, split_address
from ..load.tested import load_test
from .alone import load_any
from .check import check_rack

READ = "read"
"""The rule for files that can't be read or built."""

RACK, PYTHON = ".toml", ".py"
CHECKED = (RACK, PYTHON, SUFFIX, STRUCTURED_SUFFIX, STEPS_SUFFIX)
"""Suffixes of the files that are checked."""


@dataclass(frozen=True, slots=True)
class LineRemark:
    """A problem on a line."""

    file: str
    line: int  # from 1
    column: int | None  # from 1; None for the whole line
    level: str  # level of the rule: "error", "warning" or "note"
    rule: str
    text: str


def check_texts(file: Path, texts: Mapping[Path, str], *, run_python: bool) -> list[LineRemark]:
    """Check a file; return the problems in it and in the files that belong to it.

    Args:
        file: a file with a suffix in `CHECKED`.
        texts: texts of the files that have unsaved changes.
        run_python: whether Python modules may run.
    """
    with unsaved(texts):
        try:
            return list(_checked(file, run_python=run_python))
        except (ValueError, SyntaxError, OSError, RecursionError) as error:
            return list(_mistakes(error, file))


def rack_of(program: Path) -> Path | None:
    """Return the first rack file in a program's folder that names the program; None if none does."""
    for rack in sorted(program.parent.glob(f"*{RACK}")):
        program_key = _tables(rack).get("program")
        if isinstance(program_key, str) and rack.parent / split_address(program_key)[0] == program:
            return rack
    return None


def _tables(path: Path) -> Mapping[str, object]:
    """Return the tables of a TOML file; empty if it is not TOML."""
    try:
        return parse_toml(read_input_text(path, TextKind.TOML), path)
    except (ValueError, OSError):
        return {}


def runs_python(spec: RackSpec) -> bool:
    """Whether loading a rack may run Python: its program, its modules, a stub, or another rack's Python."""
    if not isinstance(spec.program, str) or is_python(f"{split_address(spec.program)[0]}:any"):
        return True
    if spec.modules:
        return True
    for stub in spec.stubs.values():
        if isinstance(stub, str) and is_python(stub):
            return True
        if not isinstance(stub, str) and stub.rack:
            return True  # other racks are not followed, since they may name this one
    return False


def _checked(file: Path, *, run_python: bool) -> Iterator[LineRemark]:
    """Yield the findings in a file, as its suffix requires. Errors of reading or building it are raised."""
    is_ladder = file.suffix in (SUFFIX, STRUCTURED_SUFFIX)
    tests = read_test_file(file) if is_ladder else None
    if file.suffix == RACK:
        if _is_rack(file) and _may_load(file, run_python=run_python):
            yield from _findings(file)
    elif tests is not None:
        if _may_load(tests.rack, run_python=run_python):
            load_test(tests, next(iter(tests.routines)))
    else:
        rack = _rack_to_check(file, run_python=run_python)
        if file.suffix == PYTHON:
            compile(read_input_text(file, TextKind.PYTHON), str(file), "exec", dont_inherit=True)
        if rack is not None or is_ladder:
            yield from _findings(rack or file)
        elif file.suffix == STEPS_SUFFIX:
            load_program(str(file))


def _is_rack(file: Path) -> bool:
    """Whether a TOML file may be a rack file rather than another tool's; an unreadable file may be one."""
    tables = _tables(file)
    return not tables or bool({"program", "slot"} & tables.keys())


def _may_load(rack: Path, *, run_python: bool) -> bool:
    """Whether a rack may be loaded with its program; raise RackFileError if the file can't be read."""
    spec = load_rack_file(rack).spec
    return run_python or not runs_python(spec)


def _rack_to_check(program: Path, *, run_python: bool) -> Path | None:
    """Return the rack file to check a program with; None to check the program alone."""
    rack = rack_of(program)
    try:
        return rack if rack is not None and _may_load(rack, run_python=run_python) else None
    except RackFileError:
        return None  # its problems are reported for the rack file itself


def _findings(file: Path) -> Iterator[LineRemark]:
    """Yield the findings of a rack file, or of a program without a rack, as problems on lines."""
    job, alone = load_any(str(file))
    for finding in check_rack(job, alone=alone).findings:
        text = f"{finding.text}; {finding.row.remedy}"
        yield LineRemark(
            finding.place.file, max(finding.place.line, 1), None, finding.row.level, finding.rule, text
        )


def _mistakes(error: BaseException, file: Path) -> Iterator[LineRemark]:
    """Yield the mistakes from an error's innermost cause with a place."""
    causes = [error]
    while causes[-1].__cause__ is not None:
        causes.append(causes[-1].__cause__)
    for cause in reversed(causes):
        mistakes = list(_mistakes_of_cause(cause, file))
        if mistakes:
            yield from mistakes
            return
    yield _mistake(Site(), str(error), file)


def _mistakes_of_cause(error: BaseException, file: Path) -> Iterator[LineRemark]:
    """Yield the mistakes that an error reports with a line; ignore its causes."""
    if isinstance(error, SyntaxError):
        yield _mistake(Site(line=error.lineno or 1, column=error.offset), error.msg, file)
    elif isinstance(error, BuildError):
        for problem in error.problems:
            yield _mistake(problem.site, f"{problem.text}; {problem.remedy}", file, problem.rule)
    elif isinstance(error, SiteError):
        reasons = getattr(error, "reasons", ()) or [error.reason] * len(error.sites)
        for site, reason in zip(error.sites, reasons, strict=False):
            if site.line is not None:
                yield _mistake(site, reason, file)


def _mistake(site: Site, text: str, file: Path, rule: str = "") -> LineRemark:
    """Return the problem at a site; `file` and line 1 replace a file or line that the site lacks."""
    return LineRemark(site.file or str(file), site.line or 1, site.column, "error", rule or READ, text)
