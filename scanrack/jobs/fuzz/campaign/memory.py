"""The files that a campaign keeps besides its state: its corpus, and failures until they are shrunk.

RACK-fuzz/corpus/HASH.json    a run with a new feature
RACK-fuzz/finds/HASH.json     a failure as found, written at once; removed once it is in the state
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from scanrack.runtime.config.rackspec import RackSpec

from ..learning import scenario_of
from ..scenarios.scenario import Scenario
from ..search import Counterexample
from .recipes import CORPUS, FINDS, MOST_FILES, Origin, Recipe, RecipeFolder, recipes_in

MOST_NAMED = 10
"""Largest number of ignored files that are named one by one."""


class Memory:
    """The recipe files of a campaign.

    Args:
        folder: folder of the campaign; the caller holds its lock.
        report: called with a sentence about ignored files.

    Raises:
        OSError: a folder can't be created.
    """

    def __init__(self, folder: Path, origin: Origin, spec: RackSpec, report: Callable[[str], object]) -> None:
        self.corpus, self.finds = (RecipeFolder(folder / name, origin) for name in (CORPUS, FINDS))
        for store in (self.corpus, self.finds):
            store.folder.mkdir(parents=True, exist_ok=True)
        self._spec, self._report, self._left_out = spec, report, 0
        self._written: set[str] = set()  # names of our files in the corpus folder
        self._spared: frozenset[str] = frozenset()  # those that have not been run again

    def known(self, others: Iterable[Path] = ()) -> tuple[Scenario, ...]:
        """Return each scenario of the corpus and of other places once.

        Args:
            others: campaign folders, recipe folders and traces.

        Raises:
            ValueError: one of them is neither.
            OSError: one of them can't be read.
        """
        own = list(self._read(self.corpus.folder))
        self._spared = frozenset(file.name for file, _ in own)
        self._written |= self._spared
        scenarios = [recipe.scenario for _, recipe in own]
        for other in others:
            scenarios += self._of(other)
        unique = {repr(scenario): scenario for scenario in scenarios}
        return tuple(unique.values())[:MOST_FILES]

    def left(self) -> Iterator[tuple[Path, Recipe]]:
        """Yield the failures that an earlier session found but did not shrink."""
        return self._read(self.finds.folder)

    def _of(self, other: Path) -> Iterator[Scenario]:
        if other.suffix == ".mcap":
            yield scenario_of(other, self._spec)
        elif not other.is_dir():
            raise ValueError(f"--corpus {other}: it is neither a folder nor a recording (.mcap)")
        else:
            recipe_folders = [other / name for name in (CORPUS, FINDS) if (other / name).is_dir()]
            for folder in recipe_folders or [other]:
                yield from (recipe.scenario for _, recipe in self._read(folder))

    def _read(self, folder: Path) -> Iterator[tuple[Path, Recipe]]:
        for file, recipe in recipes_in(folder, self._spec):
            if isinstance(recipe, str):
                self._leave_out(file, recipe)
            elif recipe.scenario.is_possible(self._spec):
                yield file, recipe

    def _leave_out(self, file: Path, why: str) -> None:
        self._left_out += 1
        if self._left_out <= MOST_NAMED:
            self._report(f"left out: {file}: {why}")
        elif self._left_out == MOST_NAMED + 1:
            self._report("left out: further files of this kind")

    def all_were_run(self) -> None:
        """Record that the scenarios of `known` have been run, so that `keep` may remove their files."""
        self._spared = frozenset()

    def keep(self, scenarios: Iterable[Scenario], shrunk: Iterable[Counterexample]) -> None:
        """Write the corpus; remove files of dropped scenarios, and of failures that are in the state.

        Ignored files stay.

        Raises:
            OSError: a file can't be written.
        """
        names = set(map(self.corpus.put, scenarios))
        for name in self._written - names - self._spared:
            (self.corpus.folder / name).unlink(missing_ok=True)
        self._written = names | self._spared
        for failure in shrunk:
            self.finds.remove(failure.scenario, failure.broken.invariant)
