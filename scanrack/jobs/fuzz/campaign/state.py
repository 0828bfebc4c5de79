"""The state of a campaign: a file that is written after every task and read by the next run."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from hashlib import sha256
from itertools import chain, count
from pathlib import Path, PurePath
from typing import Any

from scanrack.io_images.doors import json_value
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.text_limits import TextKind
from scanrack.runtime.config.rackspec import RackSpec, profile_in
from scanrack.traces.files.guard import beginning
from scanrack.traces.files.newfile import new_file
from scanrack.traces.files.portable import no_device

from ..aim.corpus import PAIR_WORTH, Corpus, worth_of
from ..run import BrokenInvariant, TrialBench
from ..scenarios.scenario import Scenario
from ..search import Counterexample, RunTotals, SearchReport, all_but
from .recipes import CORPUS, FINDS

RECORDING = "recording"
"""Key in the corpus of a scenario from a recording."""

TAKEN = (RECORDING, CORPUS, FINDS, "coverage.html")
"""Names in a campaign's folder that are not available for failures."""


class CampaignError(ValueError):
    """The campaign can't continue; the message has the cause."""


@dataclass(slots=True)
class State(RunTotals):
    """The state of a campaign; of the totals, only runs, scans, rules and applied invariants are saved.

    Attributes:
        rack: path of the rack file, as given; empty before the first run.
        corpus: scenarios that every other task varies. `RECORDING` is the key for a recording's scenario. The
            key of a former failure is the key for a scenario that no longer fails.
        found: the smallest scenario of each failure, by the failure's key.
        folders: folder name of each failure ever found, by the failure's key.
        kept: corpus of this session, scenarios with new features; saved as recipes.
        stale: number of runs since the program last did something new; not saved.
        steps: hexadecimal digest of all runs in the order of the tasks; equal for equal runs.
    """

    rack: str = ""
    tasks: int = 0
    corpus: dict[str, Scenario] = field(default_factory=dict)
    found: dict[str, Counterexample] = field(default_factory=dict)
    folders: dict[str, str] = field(default_factory=dict)
    steps: str = ""
    kept: Corpus = field(default_factory=Corpus, compare=False)
    stale: int = field(default=0, compare=False)

    def add(self, report: SearchReport) -> list[Counterexample]:
        """Add the report of a task; return the failures that are new or have a smaller scenario."""
        self.tasks += 1
        self.add_totals(report)
        self.steps = sha256(self.steps.encode() + report.steps).hexdigest()
        is_new = any(worth_of(feature) > PAIR_WORTH for feature in report.corpus.seen - self.kept.seen)
        self.stale = 0 if is_new else self.stale + report.runs - report.shrinking
        self.kept.merge(report.corpus)
        self.kept.runs += report.runs - report.shrinking
        return self.note(report.found)

    def note(self, found: Iterable[Counterexample]) -> list[Counterexample]:
        """Add failures; return those that are new or have a smaller scenario."""
        news = []
        for counterexample in found:
            known = self.found.get(counterexample.broken.key)
            if known is None or counterexample.scenario.size < known.scenario.size:
                self.found[counterexample.broken.key] = counterexample
                self._give_folder(counterexample.broken)
                news.append(counterexample)
        return news

    def _give_folder(self, broken: BrokenInvariant) -> None:
        """Name a failure's folder after its invariant; add a number if the name is taken, ignoring case."""
        if broken.key not in self.folders:
            numbered = (f"{broken.invariant}-{number}" for number in count(2))
            names = chain([no_device(broken.invariant)], numbered)
            used_names = {name.casefold() for name in (*self.folders.values(), *TAKEN)}
            self.folders[broken.key] = next(name for name in names if name.casefold() not in used_names)

    def drop_impossible(self, spec: RackSpec) -> list[BrokenInvariant]:
        """Drop scenarios with older firmware than the program needs; return the dropped failures."""
        impossible = {
            key: counterexample
            for key, counterexample in self.found.items()
            if not counterexample.scenario.is_possible(spec)
        }
        for key in impossible:
            del self.found[key]
        self.corpus = {key: scenario for key, scenario in self.corpus.items() if scenario.is_possible(spec)}
        return [counterexample.broken for _key, counterexample in sorted(impossible.items())]

    def recheck(self, bench: TrialBench) -> list[BrokenInvariant]:
        """Repeat the known failures; return those that no longer occur.

        Scenarios that no longer fail move to the corpus. Failures of invariants that the bench lacks are
        kept.
        """
        fixed = []
        rules = profile_in(bench.spec.slot, None).rules
        before = {
            key: stored
            for key, stored in sorted(self.found.items())
            if stored.broken.invariant in bench.names
        }
        for key in before:
            del self.found[key]
        for key, counterexample in before.items():
            others = {other for other, known in before.items() if known.broken.cause in rules}
            broken = bench.run(
                counterexample.scenario, without=all_but(bench, counterexample.broken, others)
            ).broken
            if broken is None:
                self.corpus[key] = counterexample.scenario
                fixed.append(counterexample.broken)
            else:  # the failure may now have another line number
                self.folders.setdefault(broken.key, self.folders[key])
                self.note([replace(counterexample, broken=broken)])
        return fixed

    def to_json(self) -> dict[str, Any]:
        """Return the state as JSON types."""
        return {
            "rack": self.rack,
            "tasks": self.tasks,
            "runs": self.runs,
            "scans": self.scans,
            "rules": dict(sorted(self.rules.items())),
            "corpus": {rule: scenario.to_json() for rule, scenario in sorted(self.corpus.items())},
            "found": [_found_json(counterexample) for _, counterexample in sorted(self.found.items())],
            "folders": dict(sorted(self.folders.items())),
            "applied": sorted(self.applied),
            "steps": self.steps,
        }

    @classmethod
    def from_json(cls, given: dict[str, Any]) -> State:
        """Return the state that `to_json` has converted.

        Raises:
            ValueError: a value is illegal.
        """
        try:
            counterexamples = [_found(row) for row in given["found"]]
            state = cls(
                _text(given["rack"]),
                _count(given["tasks"]),
                {rule: Scenario.from_json(row) for rule, row in given["corpus"].items()},
                {counterexample.broken.key: counterexample for counterexample in counterexamples},
                {key: _folder(name) for key, name in given["folders"].items()},
                _text(given.get("steps", "")),
                runs=_count(given["runs"]),
                scans=_count(given["scans"]),
                rules=Counter({rule: _count(times) for rule, times in given["rules"].items()}),
                applied=set(_texts(given["applied"])),
            )
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"invalid campaign state: {error!r}") from None
        homeless = state.found.keys() - state.folders.keys()
        if homeless:
            raise ValueError(f"invalid campaign state: {min(homeless)} has no folder")
        return state


def _count(value: object) -> int:
    if type(value) is not int or value < 0:
        raise ValueError(f"invalid campaign state: {value!r:.40} is not a count")
    return value


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise ValueError(f"invalid campaign state: {value!r:.40} is not text")
    return value


def _texts(value: object) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise ValueError(f"invalid campaign state: {value!r:.40} is not a list")
    return tuple(map(_text, value))


def _folder(value: object) -> str:
    """Return a folder name; refuse one that leads out of the campaign's folder."""
    name = _text(value)
    if PurePath(name).name != name or "\\" in name:
        raise ValueError(f"invalid campaign state: {name!r:.40} is not the name of a folder")
    return name


def _found_json(found: Counterexample) -> dict[str, Any]:
    return {"scenario": found.scenario.to_json(), "after": found.after, **asdict(found.broken)}


_KINDS: Mapping[str, Callable[[object], Any]] = {"int": _count, "str": _text, "tuple[str, ...]": _texts}
"""Functions that check the fields of a `BrokenInvariant`, by type."""


def _found(given: dict[str, Any]) -> Counterexample:
    broken = {
        attribute.name: _KINDS[str(attribute.type)](given[attribute.name])
        for attribute in fields(BrokenInvariant)
    }
    return Counterexample(
        Scenario.from_json(given["scenario"]), BrokenInvariant(**broken), _count(given["after"])
    )


STATE = beginning("the state of a campaign", b'{\n "rack"')


def read_state(file: Path, rack: str) -> State:
    """Return the state in a file, or an empty state if the file is missing.

    Raises:
        CampaignError: the file can't be read, is not a state, or belongs to another rack.
    """
    if not file.exists():
        return State(rack)
    try:
        text = read_input_text(file, TextKind.STATE)
        state = State.from_json(json_value(text, TextKind.STATE))
    except (OSError, ValueError) as error:
        raise CampaignError(f"{file}: {error}; move it away to start again") from error
    if state.rack != rack:
        raise CampaignError(
            f"{file} is of a search of {state.rack}, not of {rack}: give --out another folder"
        )
    return state


def write_state(state: State, file: Path) -> None:
    """Write a state to a file, replacing the previous one.

    Raises:
        OSError: the file can't be written.
    """
    with new_file(file, STATE) as opened:
        opened.write(json.dumps(state.to_json(), indent=1) + "\n")
