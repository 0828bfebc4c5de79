"""Checks of documents. Checks that run Python use their own process, since they can hang or print."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import astuple
from pathlib import Path

from scanrack.jobs.check.texts import LineRemark, check_texts
from scanrack.jobs.trust.launcher import PIPE, TimeoutExpired, launch

PATIENCE_S = 20
"""Time limit for a check that runs Python, s; after this time, its process is ended."""


def findings(file: Path, texts: Mapping[Path, str], *, trusted: bool) -> list[LineRemark]:
    """Return the findings in a file and in the files that belong to it.

    Args:
        texts: texts of the open documents.
        trusted: whether Python modules in its folder may be run.
    """
    if not trusted:
        return check_texts(file, texts, run_python=False)
    request = json.dumps([str(file), {str(path): text for path, text in texts.items()}])
    with launch(f"{__name__}:main", stdin=PIPE, stdout=PIPE, own_session=True) as helper:
        try:
            output, _ = helper.communicate(request.encode(), timeout=PATIENCE_S)
        except TimeoutExpired:
            helper.kill()
            return [_failed_check(file, f"did not return within {PATIENCE_S} s")]
    if helper.returncode:
        return [_failed_check(file, f"ended the check with status {helper.returncode}")]
    return [LineRemark(*row) for row in json.loads(output)]


def _failed_check(file: Path, problem: str) -> LineRemark:
    return LineRemark(str(file), 1, None, "warning", "read", f"a check runs this program, which {problem}")


def main() -> None:
    """Run a check in its own process: request on standard input, findings on standard output."""
    output = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8", newline="\n")
    with redirect_stdout(sys.stderr):  # the program's own output
        file, texts = json.load(sys.stdin.buffer)
        opened = {Path(path): text for path, text in texts.items()}
        remarks = check_texts(Path(file), opened, run_python=True)
    with output:
        json.dump([astuple(remark) for remark in remarks], output)
