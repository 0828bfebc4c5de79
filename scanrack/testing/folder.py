"""The folder of a test's artifacts.

scanrack-artifacts/                     with a .gitignore that marks it as made by scanrack
test_feeder.py--test_strokes/         of test_feeder.py::test_strokes
.scanrack-test                      the test; only folders with this file are emptied
feeder.mcap, feeder.html
.scanrack-passed                    if the test has passed
passed/feeder.mcap                  of the last run that passed, while later runs fail
"""

from __future__ import annotations

import hashlib
import re
import shutil
from contextlib import suppress
from pathlib import Path

from scanrack.traces.files.guard import OwnedError
from scanrack.traces.files.locking import is_being_recorded
from scanrack.traces.files.portable import no_device

MARK = ".scanrack-test"
PASSED_MARK = ".scanrack-passed"
PASSED = "passed"
IGNORE = "# made by the pytest plugin of scanrack\n*\n"
LONGEST = 80
"""Maximum number of characters in a folder's name, without its digest."""

DIGEST = 8

_PLAIN = re.compile(r"\w+(\.\w+)*+((/|::)\w+(\.\w+)*+)*+", re.ASCII)


def folder_names(test: str) -> tuple[str, ...]:
    """Return the possible names of a test's folder; the second is used if the first belongs to another test.

    >>> folder_names("tests/test_feeder.py::test_strokes")
    ('tests-test_feeder.py--test_strokes', 'tests-test_feeder.py--test_strokes-c9a7e8d1')
    >>> folder_names("test_feeder.py::test_file[../../etc/passwd]")
    ('test_feeder.py--test_file-etc-passwd-0a2bd06b',)
    """
    name = test.replace("::", "--").replace("/", "-")
    unique = f"{file_name(name)}-{hashlib.sha256(test.encode('utf-8', 'surrogatepass')).hexdigest()[:DIGEST]}"
    is_plain = len(name) <= LONGEST and _PLAIN.fullmatch(test)
    return (name, unique) if is_plain else (unique,)


def file_name(text: str) -> str:
    """Convert text to a file name that is valid on every system.

    >>> file_name("../my rack#2"), file_name("aux")
    ('my-rack-2', 'aux_')
    """
    clean = re.sub(r"-?[^\w.-]+-?|\.{2,}", "-", text, flags=re.ASCII)
    return no_device(re.sub(r"-{3,}", "-", clean)[:LONGEST].strip(".-"))


class ArtifactFolder:
    """The folder of a test, created at its first use.

    Args:
        base: the folder of all tests.
        test: pytest's node ID of the test.
    """

    def __init__(self, base: Path, test: str) -> None:
        self._base, self._test = base, test
        self._path: Path | None = None

    @property
    def path(self) -> Path:
        """The folder; the first access creates it and removes the artifacts of an earlier run.

        Raises:
            OwnedError: folders that scanrack did not create already use its names, or another run is writing
                to it.
            OSError: the folder can't be created.
        """
        if self._path is None:
            _make_base(self._base)
            self._path = self._create()
        return self._path

    def _create(self) -> Path:
        """Create or empty the test's folder, and mark it.

        Raises:
            OwnedError: none of its names can be used, or another run is writing to it.
        """
        for name in folder_names(self._test):
            path = self._base / name
            if self._claim(path):
                path.mkdir(parents=True, exist_ok=True)
                (path / MARK).write_text(self._test, "utf-8", "backslashreplace", newline="\n")
                return path
        raise OwnedError(
            f"{path} was not made by scanrack for {self._test}: move it, or choose another folder with "
            "--scanrack-artifacts"
        )

    def _claim(self, path: Path) -> bool:
        """Empty the folder if it belongs to this test; return whether the test may use it."""
        if path.is_symlink() or (path.exists() and not path.is_dir()):
            return False
        if not path.exists() or not any(path.iterdir()):
            return True
        if not self._belongs_to_test(path):
            return False
        for trace in path.glob("*.mcap"):
            if is_being_recorded(trace):
                raise OwnedError(
                    f"{trace} is being recorded by another run of the test: "
                    "choose another folder with --scanrack-artifacts"
                )
        _empty(path)
        return True

    def passed_trace(self, trace: Path) -> Path | None:
        """Return the trace with the same name from the last passed run; None if it does not exist."""
        path = trace.parent / PASSED / trace.name
        return path if path.is_file() else None

    def keep_passed(self) -> None:
        """Keep the folder, and mark its run as passed."""
        if self._path is not None:
            (self._path / PASSED_MARK).touch()
            _remove(self._path / PASSED)

    def _belongs_to_test(self, path: Path) -> bool:
        """Return whether the mark in a folder names this test."""
        try:
            marked = (path / MARK).read_bytes()
        except OSError:
            return False
        return marked == self._test.encode("utf-8", "backslashreplace")

    def remove(self) -> None:
        """Remove the folder and its contents, if it was created."""
        path, self._path = self._path, None
        if path is not None and not path.is_symlink() and self._belongs_to_test(path):
            shutil.rmtree(path)

    def remove_if_unused(self) -> None:
        """Remove the folder if the test left nothing in it."""
        marks = {MARK, PASSED_MARK, PASSED}
        if self._path is not None and all(path.name in marks for path in self._path.iterdir()):
            self.remove()


def _empty(path: Path) -> None:
    """Empty a test's folder, except for the traces of the last run that passed."""
    passed = path / PASSED
    if (path / PASSED_MARK).exists():  # the previous run has passed
        _remove(passed)
        passed.mkdir()
        for trace in path.glob("*.mcap"):
            trace.replace(passed / trace.name)
    for entry in path.iterdir():
        if entry != passed or entry.is_symlink():
            _remove(entry)


def _remove(path: Path) -> None:
    """Remove a file, a link or a folder if it exists; the target of a link is kept."""
    if path.is_symlink() or not path.is_dir():
        path.unlink(missing_ok=True)
    else:
        shutil.rmtree(path)


def _make_base(base: Path) -> None:
    """Create the folder of all tests with its .gitignore, unless the folder exists."""
    with suppress(FileExistsError):
        base.parent.mkdir(parents=True, exist_ok=True)
        base.mkdir()
        (base / ".gitignore").write_text(IGNORE, encoding="utf-8", newline="\n")


def remove_base(base: Path) -> None:
    """Remove the folder of all tests if scanrack created it and no test has artifacts."""
    ignore = base / ".gitignore"
    with suppress(OSError):
        if [*base.iterdir()] == [ignore] and ignore.read_text(encoding="utf-8") == IGNORE:
            ignore.unlink()
            base.rmdir()
