"""Recipes of runs. A recipe is a file of 100 to 600 bytes that determines a run.

    {"scenario": {...}, "scans": 1000, "rack": HASH, "program": HASH, "version": "1.0"}

A folder of recipes holds the corpus of a campaign, or its failures that have not been shrunk yet. The name of
a file is the hash of its text, so incomplete and foreign files are detected.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from hashlib import sha256
from itertools import islice
from pathlib import Path

from scanrack.io_images.doors import json_value
from scanrack.io_images.input_files import read_input
from scanrack.io_images.text_limits import TextKind
from scanrack.io_images.versions import distribution_version
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.traces.files.guard import beginning
from scanrack.traces.files.newfile import new_file

from ...load.loading import LoadedRack
from ..scenarios.scenario import Scenario

RECIPE = beginning("a recipe of a run", b'{"scenario"')

CORPUS, FINDS = "corpus", "finds"
"""Folders of recipes in the folder of a campaign."""

SUFFIX, DIGITS = ".json", 16
"""Suffix of a recipe file, and number of hexadecimal digits in its name."""

MOST_BYTES, MOST_FILES = 64 * 1024, 1_000
"""Maximum size of a recipe file, and maximum number of files that are read from a folder."""

MOST_SCANS = 10**15
"""Maximum length of a run in a recipe, scans."""


@dataclass(frozen=True, slots=True)
class Origin:
    """The rack, program and length of a run."""

    scans: int
    rack: str  # hash of the rack file
    program: str  # hash of the program's file
    version: str  # version of scanrack

    @classmethod
    def of(cls, job: LoadedRack, scans: int) -> Origin:
        """Return the origin of a job's runs.

        Raises:
            OSError: a file can't be read.
        """
        rack, program = (_hash(file.read_bytes()) for file in (job.rack_file, job.program))
        return cls(scans, rack, program, distribution_version("scanrack"))


@dataclass(frozen=True, slots=True)
class Recipe:
    """A run.

    Attributes:
        broken: name of the broken invariant; empty in a corpus. It has no effect on the run.
    """

    scenario: Scenario
    origin: Origin
    broken: str = ""

    def text(self) -> str:
        """Return the text of the recipe's file, which is a single line."""
        scenario = {key: value for key, value in self.scenario.to_json().items() if value}
        broken = {"broken": self.broken} if self.broken else {}
        recipe = {"scenario": scenario, **asdict(self.origin), **broken}
        return json.dumps(recipe, separators=(",", ":")) + "\n"

    @classmethod
    def from_text(cls, text: str) -> Recipe:
        """Return the recipe in the text of a file.

        Raises:
            ValueError: the text is not a recipe.
        """
        recipe = json_value(text, TextKind.SCENARIO)
        if not isinstance(recipe, dict):
            raise ValueError(f"{recipe!r:.40}: must be a JSON object")
        scans = recipe.get("scans")
        if type(scans) is not int or not 0 < scans <= MOST_SCANS:
            raise ValueError(f"scans = {scans!r:.40}: must be 1 to {MOST_SCANS:,}")
        texts = {key: recipe.get(key, "") for key in ("rack", "program", "version", "broken")}
        for key, value in texts.items():
            if not isinstance(value, str):
                raise ValueError(f"{key} = {value!r:.40}: must be a text")
        broken = texts.pop("broken")
        return cls(Scenario.from_json(recipe.get("scenario")), Origin(scans, **texts), broken)


@dataclass(frozen=True, slots=True)
class RecipeFolder:
    """A folder for recipes of one origin."""

    folder: Path
    origin: Origin

    def with_absolute_paths(self) -> RecipeFolder:
        """Return the same folder with an absolute path."""
        return RecipeFolder(self.folder.absolute(), self.origin)

    def put(self, scenario: Scenario, broken: str = "") -> str:
        """Write a recipe to disk; return the name of its file.

        Raises:
            OSError: the file can't be written.
        """
        text = Recipe(scenario, self.origin, broken).text()
        name = _name(text)
        if not (self.folder / name).exists():
            with new_file(self.folder / name, RECIPE, locked=True) as file:
                file.write(text)
        return name

    def remove(self, scenario: Scenario, broken: str) -> None:
        """Remove a recipe if it exists."""
        (self.folder / _name(Recipe(scenario, self.origin, broken).text())).unlink(missing_ok=True)


def read_recipe(file: Path) -> Recipe:
    """Return the recipe in a file whose name is its hash.

    Raises:
        ValueError: the file is incomplete, foreign, or not a recipe.
        OSError: the file can't be read.
    """
    data = read_input(file, MOST_BYTES)
    if file.name != f"{_hash(data)}{SUFFIX}":
        raise ValueError("the name is not the hash of the text: the file is incomplete or foreign")
    return Recipe.from_text(data.decode("utf-8"))


def recipes_in(folder: Path, spec: RackSpec) -> Iterator[tuple[Path, Recipe | str]]:
    """Yield each file of a folder with its recipe, or with the reason why the file is ignored.

    Hidden files and all files after the first 1,000 are skipped.
    """
    if not folder.is_dir():
        return
    files = sorted(islice((path for path in folder.iterdir() if path.name[0] != "."), MOST_FILES))
    for file in files:
        try:
            recipe = read_recipe(file)
            recipe.scenario.check(spec)
        except OSError as error:
            yield file, error.strerror or str(error)
        except (ValueError, RecursionError) as error:
            yield file, str(error)
        else:
            yield file, recipe


def _name(text: str) -> str:
    return f"{_hash(text.encode())}{SUFFIX}"


def _hash(data: bytes) -> str:
    return sha256(data).hexdigest()[:DIGITS]
