"""Manages a campaign's files other than its state: the corpus, and failures that are not shrunk yet.

RACK-fuzz/corpus/HASH.json    a run with a new feature
RACK-fuzz/finds/HASH.json     a failure as found; removed once it is in the state
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
"""Maximum number of ignored files in messages."""


class Memory:
    """The recipe files of a campaign.

    Args:
        folder: folder of the campaign, locked by the caller.
        report: called with a message about ignored files.

    Raises:
        OSError: a folder can't be created.
    """

    def __init__(self, folder: Path, origin: Origin, spec: RackSpec, report: Callable[[str], object]) -> None:
        self.corpus, self.finds = (RecipeFolder(folder / name, origin) for name in (CORPUS, FINDS))
        for store in (self.corpus, self.finds):
            store.folder.mkdir(parents=True, exist_ok=True)
        self._spec, self._report = spec, report
        self._ignored = 0  # number of ignored files
        self._own_files: set[str] = set()  # names of the campaign's files in the corpus folder
        self._not_rerun: frozenset[str] = frozenset()  # names of own files that have not been run again

    def known(self, sources: Iterable[Path] = ()) -> tuple[Scenario, ...]:
        """Return the scenarios of the corpus and of other sources, without duplicates.

        Args:
            sources: campaign folders, recipe folders and traces.

        Raises:
            ValueError: a source is of a different kind.
            OSError: a source can't be read.
        """
        own_recipes = list(self._read(self.corpus.folder))
        self._not_rerun = frozenset(file.name for file, _ in own_recipes)
        self._own_files |= self._not_rerun
        scenarios = [recipe.scenario for _, recipe in own_recipes]
        for source in sources:
            scenarios += self._scenarios_in(source)
        unique = {repr(scenario): scenario for scenario in scenarios}
        return tuple(unique.values())[:MOST_FILES]

    def unshrunk_failures(self) -> Iterator[tuple[Path, Recipe]]:
        """Yield the failures that an earlier session found but did not shrink."""
        return self._read(self.finds.folder)

    def _scenarios_in(self, source: Path) -> Iterator[Scenario]:
        """Yield the scenarios of a trace, a campaign folder, or a recipe folder."""
        if source.suffix == ".mcap":
            yield scenario_of(source, self._spec)
        elif not source.is_dir():
            raise ValueError(f"--corpus {source}: it is neither a folder nor a recording (.mcap)")
        else:
            recipe_folders = [source / name for name in (CORPUS, FINDS) if (source / name).is_dir()]
            for folder in recipe_folders or [source]:
                yield from (recipe.scenario for _, recipe in self._read(folder))

    def _read(self, folder: Path) -> Iterator[tuple[Path, Recipe]]:
        """Yield the recipes that are possible on the rack, with their files; report unusable files."""
        for file, recipe in recipes_in(folder, self._spec):
            if isinstance(recipe, str):
                self._report_ignored(file, recipe)
            elif recipe.scenario.is_possible(self._spec):
                yield file, recipe

    def _report_ignored(self, file: Path, reason: str) -> None:
        """Report an ignored file. After `MOST_NAMED` files, say once that there are more."""
        self._ignored += 1
        if self._ignored <= MOST_NAMED:
            self._report(f"ignored: {file}: {reason}")
        elif self._ignored == MOST_NAMED + 1:
            self._report("ignored: more files that can't be used")

    def all_were_run(self) -> None:
        """Record that the scenarios of `known` have been run, so that `keep` can remove their files."""
        self._not_rerun = frozenset()

    def keep(self, scenarios: Iterable[Scenario], shrunk: Iterable[Counterexample]) -> None:
        """Write the corpus. Remove the files of dropped scenarios and of shrunk failures.

        Ignored files are kept.

        Raises:
            OSError: a file can't be written.
        """
        names = set(map(self.corpus.put, scenarios))
        for name in self._own_files - names - self._not_rerun:
            (self.corpus.folder / name).unlink(missing_ok=True)
        self._own_files = names | self._not_rerun
        for failure in shrunk:
            self.finds.remove(failure.scenario, failure.broken.invariant)
