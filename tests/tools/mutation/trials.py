"""Runs tests against mutants, in private copies of the project; the working tree is never touched.

A mutant is tried with the tests that execute its line when nothing is wrong: first those with the
mark of a rule that the mutated line names, then those that have killed its neighbors, then the quickest.
Verdicts are kept in the cache directory. That a test has killed a mutant holds as long as that test's file
and the sources are the same; that a mutant survived, as long as all tests are.
"""

from __future__ import annotations

import compileall
import hashlib
import json
import os
import py_compile
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from string import ascii_uppercase
from typing import Any

from .operators import Mutant
from .plugin import NOT_THE_COPY, TASK

FRONT = "scanrack"
"""What is the package itself."""
ROOMS = ("io_images", "ladder", "rockwell", "runtime", "traces")
BESIDE = ("tests", "docs", "examples", "conftest.py", "pyproject.toml")
RULE_ID = re.compile(r"\b[A-Z]{2,4}-[A-Z]?\d\d\b")
NO_TESTS = 5
"""Exit status of pytest: it has found none."""
FIRST_STAGE_S = 3.0
"""Processor time of the tests that are tried first; the others follow in a second run."""
STAGE_LIMIT_S = 900.0
"""After so long on the wall clock a run of pytest counts as hung, whatever its tests' limits."""


class ProjectCopy:
    """A copy of the project in which mutants are made.

    Args:
        root: the project.
        place: where the copy goes; it is left to the caller to remove it.
    """

    def __init__(self, root: Path, place: Path) -> None:
        self.place = place.resolve()
        self.package = self.place / "scanrack"
        leave_out = shutil.ignore_patterns("__pycache__", "*.mcap")
        shutil.copytree(root / FRONT, self.package, ignore=leave_out, symlinks=True)
        for room in ROOMS:
            (self.package / room).unlink(missing_ok=True)  # a link, where the system has them
            shutil.copytree(root / room, self.package / room, ignore=leave_out)
        for name in BESIDE:
            if (root / name).is_dir():
                shutil.copytree(root / name, self.place / name, ignore=leave_out)
            else:
                shutil.copy(root / name, self.place / name)
        checked = py_compile.PycInvalidationMode.CHECKED_HASH  # a mutant may be as long and as old
        compileall.compile_dir(self.package, quiet=2, invalidation_mode=checked)

    def file(self, path: str) -> Path:
        """Return the copy of a file of the project; `scanrack` is the package itself."""
        return self.package / path.removeprefix(f"{FRONT}/")

    def run(self, task: dict[str, Any], files: Sequence[str], *, limit_s: float, first_only: bool) -> Run:
        """Run tests with the plugin; return what came of it."""
        task_file, report = self.place / "task.json", self.place / "report.json"
        report.unlink(missing_ok=True)
        usual: dict[str, Any] = {"trace": {}, "order": None, "seconds": {}}
        task = {**usual, **task, "root": str(self.place), "report": str(report)}
        task_file.write_text(json.dumps(task), encoding="utf-8")
        here = str(Path(__file__).parents[1])
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(self.place), here]),
            "PYTHONDONTWRITEBYTECODE": "1",
            "PYTEST_ADDOPTS": "",
            TASK: str(task_file),
        }
        command = [sys.executable, "-m", "pytest", "-q", "--tb=line", "-p", "no:cacheprovider"]
        command += ["-p", "mutation.plugin", f"--basetemp={self.place / 'tmp'}"]
        command += [*(["-x"] if first_only else []), *files]
        try:
            done = subprocess.run(
                command,
                cwd=self.place,
                env=environment,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                timeout=limit_s,
                check=False,
                encoding="utf-8",
            )
        except subprocess.TimeoutExpired:
            return Run(-1, {}, "the run has hung")
        if done.returncode == NOT_THE_COPY:
            raise RuntimeError(done.stdout)
        told = json.loads(report.read_text(encoding="utf-8")) if report.exists() else {}
        return Run(done.returncode, told, done.stdout)


@dataclass(frozen=True, slots=True)
class Run:
    """What came of a run of pytest: exit status (-1 = hung), the plugin's report, what it said."""

    status: int
    report: dict[str, Any]
    said: str


@dataclass(slots=True)
class Baseline:
    """The tests without a mutant.

    Attributes:
        tests: ids of the tests that pass.
        failed: ids of those that don't, which are left out.
        seconds: processor time of each.
        lines: lines that each executes, by file.
        rules: rules that each is marked with.
        fired: rules that fire in each.
    """

    tests: list[str]
    failed: list[str]
    seconds: dict[str, float]
    lines: dict[str, dict[str, list[int]]]
    rules: dict[str, list[str]]
    fired: dict[str, list[str]]

    @classmethod
    def joined(cls, parts: Iterable[Baseline]) -> Baseline:
        """Return the tests of several files as one."""
        whole = cls([], [], {}, {}, {}, {})
        for part in parts:
            whole.tests += part.tests
            whole.failed += part.failed
            whole.seconds |= part.seconds
            whole.lines |= part.lines
            whole.rules |= part.rules
            whole.fired |= part.fired
        return whole


def baseline(copy: ProjectCopy, file: str, traced: Iterable[str]) -> Baseline:
    """Run a file of tests without a mutant, noting the lines of `traced` that each executes.

    Raises:
        RuntimeError: the file can't be collected.
    """
    paths = {str(copy.file(path)): path for path in traced}
    done = copy.run({"trace": paths}, [file], limit_s=STAGE_LIMIT_S, first_only=False)
    if done.status not in (0, 1, NO_TESTS) or not done.report:
        raise RuntimeError(f"{file} can't be run without a mutant:\n{done.said[-4000:]}")
    failed = sorted(set(done.report.pop("failed")))
    passed = sorted(set(done.report.pop("passed")) - set(failed))
    return Baseline(passed, failed, **done.report)


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a mutant.

    Attributes:
        killed: whether a test failed.
        by: the test; "" if none.
        why: "failed", "time", "crashed", "not reached", "survived".
        tests: what the verdict rests on, as a hash.
    """

    killed: bool
    by: str
    why: str
    tests: str


class Trials:
    """Tries mutants, one after the other in each copy.

    Args:
        copies: the copies, one for each process at a time.
        known: the tests without a mutant.
        cache: where verdicts are kept.
        sources: patterns of the files that a verdict rests on.
    """

    def __init__(
        self, copies: Sequence[ProjectCopy], known: Baseline, cache: Path, sources: Iterable[str]
    ) -> None:
        self.known = known
        self.free = list(copies)
        self.cache = cache
        self._sources = source_hash(copies[0].package, sources)
        self._tests = {path: file_hash(copies[0].place / path) for path in {file_of(n) for n in known.tests}}
        self._support = tree_hash(copies[0].place / "tests", "support/*.py", "tools/*.py", "conftest.py")
        refusals = copies[0].package / "runtime" / "modules" / "amci3601" / "refusals.py"
        self._rules_asking = rules_asking(refusals.read_text(encoding="utf-8"))
        self._killers: Counter[tuple[str, str, str]] = Counter()

    def judge(self, mutant: Mutant) -> Verdict:
        """Return the verdict on a mutant, from the cache or by running tests."""
        place = self.cache / f"{self._key(mutant)}.json"
        verdict = self._recall(place)
        if verdict is None:
            copy = self.free.pop()
            try:
                verdict = self._try(copy, mutant)
            finally:
                self.free.append(copy)
            partial = place.with_suffix(".tmp")
            partial.write_text(json.dumps(asdict(verdict)), encoding="utf-8")
            partial.replace(place)
        if verdict.by:
            self._killers[mutant.path, mutant.scope, verdict.by] += 1
        return verdict

    def _key(self, mutant: Mutant) -> str:
        return digest(self._sources, mutant.path, str(mutant.start), str(mutant.end), mutant.new)

    def _recall(self, place: Path) -> Verdict | None:
        if not place.exists():
            return None
        verdict = Verdict(**json.loads(place.read_text(encoding="utf-8")))
        return verdict if verdict.tests == self._basis(verdict.by) else None

    def _basis(self, by: str) -> str:
        """Return the hash of what a verdict rests on: the killer's file, or all tests."""
        files = [file_of(by)] if by else sorted(self._tests)
        return digest(self._support, *(f"{file} {self._tests.get(file, 'gone')}" for file in files))

    def _try(self, copy: ProjectCopy, mutant: Mutant) -> Verdict:
        tests = self.choose(mutant)
        if not tests:
            return Verdict(False, "", "not reached", self._basis(""))
        path = copy.file(mutant.path)
        original = path.read_text(encoding="utf-8")
        path.write_text(mutant.apply(original), encoding="utf-8")
        try:
            first, rest = self._stages(tests)
            return self._stage(copy, first) or self._stage(copy, rest) or self._survived()
        finally:
            path.write_text(original, encoding="utf-8")

    def _survived(self) -> Verdict:
        return Verdict(False, "", "survived", self._basis(""))

    def _stages(self, tests: list[str]) -> tuple[list[str], list[str]]:
        total = 0.0
        for count, test in enumerate(tests):
            total += self.known.seconds[test]
            if total > FIRST_STAGE_S:
                return tests[: count + 1], tests[count + 1 :]
        return tests, []

    def _stage(self, copy: ProjectCopy, tests: list[str]) -> Verdict | None:
        """Run some tests; None if all of them passed."""
        if not tests:
            return None
        seconds = {test: 5 + 20 * self.known.seconds[test] for test in tests}
        files = list(dict.fromkeys(map(file_of, tests)))
        run = copy.run({"order": tests, "seconds": seconds}, files, limit_s=STAGE_LIMIT_S, first_only=True)
        if run.status == 0:
            return None
        failed = run.report.get("failed") or [""]
        why = "failed" if failed[0] else "crashed"
        if run.status == -1 or "took too long" in run.said:
            why = "time"
        return Verdict(True, failed[0], why, self._basis(failed[0]))

    def choose(self, mutant: Mutant) -> list[str]:
        """Return the tests that can kill a mutant, the most promising first."""
        known = self.known
        rules = {*mutant.rules, *RULE_ID.findall(mutant.old), *self._rules_asking.get(mutant.scope, ())}
        lines = set(range(mutant.first_line, mutant.last_line + 1))

        def reaches(test: str) -> bool:
            if mutant.rules:
                return not set(mutant.rules).isdisjoint(known.fired[test])
            at_import = mutant.scope.rpartition(".")[2][:1] in ("", *ascii_uppercase)  # a table, a class
            return at_import or not lines.isdisjoint(known.lines[test].get(mutant.path, ()))

        def promise(test: str) -> tuple[int, bool, float]:
            about = rules.isdisjoint(known.rules[test]) + rules.isdisjoint(known.fired[test])
            return -self._killers[mutant.path, mutant.scope, test] + about, about > 0, known.seconds[test]

        return sorted(filter(reaches, known.tests), key=promise)


def rules_asking(refusals: str) -> dict[str, list[str]]:
    """Return which rules ask each predicate of the source of the refusals.

    >>> rules_asking('Refusal("CMD-03", busy), Refusal("PST-01", busy, bits=COMMAND_ERROR)')
    {'busy': ['CMD-03', 'PST-01']}
    """
    asking: dict[str, list[str]] = {}
    for rule, predicate in re.findall(r'Refusal\("([\w-]+)", (\w+)', refusals):
        asking.setdefault(predicate, []).append(rule)
    return asking


def file_of(node: str) -> str:
    """Return the file of a test's id."""
    return node.split("::")[0]


def digest(*parts: str) -> str:
    """Return a hash of some strings."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:24]


def file_hash(path: Path) -> str:
    """Return a hash of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:24]


def tree_hash(folder: Path, *patterns: str) -> str:
    """Return a hash of the files in a folder that match."""
    paths = sorted(path for pattern in patterns for path in folder.glob(pattern))
    return digest(*(f"{path.relative_to(folder)} {file_hash(path)}" for path in paths))


def source_hash(package: Path, patterns: Iterable[str]) -> str:
    """Return a hash of the files that match, but for the commands."""
    here = [pattern.removeprefix(f"{FRONT}/") for pattern in patterns]
    names = sorted({path.relative_to(package).as_posix() for each in here for path in package.glob(each)})
    decisive = [name for name in names if not name.startswith("commands/")]
    return digest(*(f"{name} {file_hash(package / name)}" for name in decisive))
