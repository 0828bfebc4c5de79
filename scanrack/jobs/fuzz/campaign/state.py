"""The state of a campaign. Its file is written after every task, and the next session reads it."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from hashlib import sha256
from itertools import count
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
"""Key of a recording's scenario in the corpus."""

TAKEN = (RECORDING, CORPUS, FINDS, "coverage.html")
"""Reserved names in a campaign's folder, which a failure can't have."""


class CampaignError(ValueError):
    """The campaign can't continue; the message has the cause."""


@dataclass(slots=True)
class State(RunTotals):
    """The state of a campaign. Only these totals are saved: runs, scans, rules and applied invariants.

    Attributes:
        rack: path of the rack file, as the user wrote it; empty before the first run.
        corpus: scenarios that every other task varies. The key is `RECORDING` for a recording's scenario, or
            the key of a former failure for a scenario that no longer fails.
        found: smallest scenario of each failure, by the failure's key.
        folders: folder name of each failure ever found, by the failure's key.
        kept: corpus of this session: scenarios with new features. They are saved as recipes.
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
        runs = report.runs - report.shrinking
        is_new = any(worth_of(feature) > PAIR_WORTH for feature in report.corpus.seen - self.kept.seen)
        self.stale = 0 if is_new else self.stale + runs
        self.kept.merge(report.corpus)
        self.kept.runs += runs
        return self.note(report.found)

    def note(self, counterexamples: Iterable[Counterexample]) -> list[Counterexample]:
        """Add failures; return the failures that are new or have a smaller scenario."""
        news = []
        for counterexample in counterexamples:
            key = counterexample.broken.key
            known = self.found.get(key)
            if known is None or counterexample.scenario.size < known.scenario.size:
                self.found[key] = counterexample
                if key not in self.folders:
                    self.folders[key] = self._new_folder_name(counterexample.broken.invariant)
                news.append(counterexample)
        return news

    def _new_folder_name(self, invariant: str) -> str:
        """Return the name of an invariant, with a number if a folder already has this name, ignoring case."""
        used_names = {name.casefold() for name in (*self.folders.values(), *TAKEN)}
        name = no_device(invariant)
        for number in count(2):
            if name.casefold() not in used_names:
                break
            name = f"{invariant}-{number}"
        return name

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
        """Repeat the known failures; return the failures that no longer occur.

        Scenarios that no longer fail move to the corpus. Failures of invariants that the bench lacks are
        not repeated.
        """
        fixed = []
        rules = profile_in(bench.spec.slot, None).rules
        known = {
            key: counterexample
            for key, counterexample in sorted(self.found.items())
            if counterexample.broken.invariant in bench.names
        }
        refusal_keys = {key for key, refusal in known.items() if refusal.broken.cause in rules}
        for key in known:
            del self.found[key]
        for key, counterexample in known.items():
            without = all_but(bench, counterexample.broken, refusal_keys)
            broken = bench.run(counterexample.scenario, without=without).broken
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
            "corpus": {key: scenario.to_json() for key, scenario in sorted(self.corpus.items())},
            "found": [_counterexample_row(failure) for _, failure in sorted(self.found.items())],
            "folders": dict(sorted(self.folders.items())),
            "applied": sorted(self.applied),
            "steps": self.steps,
        }

    @classmethod
    def from_json(cls, saved: dict[str, Any]) -> State:
        """Return the state from the JSON types that `to_json` returned.

        Raises:
            ValueError: a value is invalid.
        """
        try:
            counterexamples = [_counterexample(row) for row in saved["found"]]
            state = cls(
                rack=_text(saved["rack"]),
                tasks=_count(saved["tasks"]),
                corpus={key: Scenario.from_json(row) for key, row in saved["corpus"].items()},
                found={counterexample.broken.key: counterexample for counterexample in counterexamples},
                folders={key: _folder(name) for key, name in saved["folders"].items()},
                steps=_text(saved.get("steps", "")),
                runs=_count(saved["runs"]),
                scans=_count(saved["scans"]),
                rules=Counter({rule: _count(times) for rule, times in saved["rules"].items()}),
                applied=set(_texts(saved["applied"])),
            )
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"invalid campaign state: {error!r}") from None
        without_folder = state.found.keys() - state.folders.keys()
        if without_folder:
            raise ValueError(f"invalid campaign state: {min(without_folder)} has no folder")
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
    """Return a folder name; raise ValueError for a path outside the campaign's folder."""
    name = _text(value)
    if PurePath(name).name != name or "\\" in name:
        raise ValueError(f"invalid campaign state: {name!r:.40} is not the name of a folder")
    return name


def _counterexample_row(failure: Counterexample) -> dict[str, Any]:
    return {"scenario": failure.scenario.to_json(), "after": failure.after, **asdict(failure.broken)}


_KINDS: Mapping[str, Callable[[object], Any]] = {"int": _count, "str": _text, "tuple[str, ...]": _texts}
"""Functions that check the fields of a `BrokenInvariant`, by type."""


def _counterexample(row: dict[str, Any]) -> Counterexample:
    """Return the counterexample in a row of the state."""
    values = {key.name: _KINDS[str(key.type)](row[key.name]) for key in fields(BrokenInvariant)}
    broken = BrokenInvariant(**values)
    return Counterexample(Scenario.from_json(row["scenario"]), broken, _count(row["after"]))


STATE = beginning("the state of a campaign", b'{\n "rack"')


def read_state(file: Path, rack: str) -> State:
    """Return the state in a file, or an empty state if the file is missing.

    Raises:
        CampaignError: the file can't be read, is not a state, or is for another rack.
    """
    if not file.exists():
        return State(rack)
    try:
        text = read_input_text(file, TextKind.STATE)
        state = State.from_json(json_value(text, TextKind.STATE))
    except (OSError, ValueError) as error:
        raise CampaignError(f"{file}: {error}; move it away to start again") from error
    if state.rack != rack:
        raise CampaignError(f"{file} is for {state.rack}, not for {rack}: use another folder with --out")
    return state


def write_state(state: State, file: Path) -> None:
    """Write a state to a file; replace the previous state.

    Raises:
        OSError: the file can't be written.
    """
    with new_file(file, STATE) as opened:
        opened.write(json.dumps(state.to_json(), indent=1) + "\n")
