"""A library of golden recordings: scenarios as data, and the recording, text and index made of them.

scenarios.toml        what is sent, to what, and what the manual says comes of it
NAME.mcap, NAME.txt   the recording of a scenario, and what `scanrack show` tells of it
index.md              a sentence each
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import unified_diff
from itertools import groupby
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from scanrack.commands.programs.run_job import run_job
from scanrack.commands.recordings.show import Contents, plain_lines, story
from scanrack.io_images.amci3601 import StatusView, status_names
from scanrack.io_images.image import UNSIGNED_MAX
from scanrack.jobs import RunOptions, load_job
from scanrack.jobs.run.result import RULES_OF_START
from scanrack.jobs.trust.extracting import attached_files
from scanrack.jobs.trust.trust import stored_programs
from scanrack.runtime import load_rack_file
from scanrack.terminal.status import DONE
from scanrack.traces import Scan, Trace, open_trace
from scanrack.traces.compare import compare, report
from scanrack.traces.signals import ALL

SCENARIOS, INDEX = "scenarios.toml", "index.md"
TRACE, TEXT = ".mcap", ".txt"


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Scenario(_Strict):
    """A behavior of the 3601, shown by a short run.

    Attributes:
        name: of its files.
        group: the heading of the index under which it stands.
        says: what it shows, in a sentence.
        start: the start of the library that comes first.
        steps: what is sent then, a program of steps.
        firmware: the module's version.
        slot: lines of the rack file's slot.machine.
        scan_ms: time from scan to scan.
        run_ms: how long it runs.
        rules: ids of the rules that fire, beside those of the start.
        bits: status bits that are set at the end, beside MODULE_OK.
        position: the position at the end; None where the manual's arithmetic does not give it.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9-]+$")]
    group: str
    says: str
    start: str = "ready"
    steps: str
    firmware: str = "4.1"
    slot: str = ""
    scan_ms: int = 4
    run_ms: int
    rules: list[str]
    bits: list[str]
    position: int | None = None

    def rack_text(self) -> str:
        """Return its rack file."""
        machine = f"\n[slot.machine]\n{self.slot}" if self.slot else ""
        return (
            f'name = "{self.name}"\nprogram = "{self.name}.steps"\nscan_ms = {self.scan_ms}\n\n'
            f'[[slot]]\nnumber = 1\nmodule = "amci3601"\nfirmware = "{self.firmware}"\n{machine}'
        )


class Library(_Strict):
    """What a library is made of.

    Attributes:
        start: programs of steps by name, with which scenarios start.
        scenario: the scenarios.
    """

    start: dict[str, str]
    scenario: list[Scenario]


@dataclass(frozen=True, slots=True)
class Made:
    """What a scenario came to.

    Attributes:
        scenario: the scenario.
        trace: its recording.
        text: what is told of it.
        wrong: what is not as the scenario says.
    """

    scenario: Scenario
    trace: Path
    text: str
    wrong: tuple[str, ...]


def load_library(folder: Path) -> Library:
    """Read the scenarios of a folder.

    Raises:
        ValueError: there is no such file, it is not TOML, or something in it is not as it should be.
    """
    path = folder / SCENARIOS
    try:
        library = Library.model_validate(tomllib.loads(path.read_text("utf-8")))
    except OSError as error:
        raise ValueError(f"{path}: the scenarios can't be read: {error.strerror}") from None
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: this is not TOML: {error}") from None
    except RecursionError:
        raise ValueError(f"{path}: tables and arrays are nested too deep") from None
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from None
    names = [scenario.name for scenario in library.scenario]
    for scenario in library.scenario:
        if scenario.start not in library.start:
            raise ValueError(f"{path}: {scenario.name}: start {scenario.start!r} is none of the starts")
        if names.count(scenario.name) > 1:
            raise ValueError(f"{path}: {scenario.name} is there twice")
    return library


def make(library: Library, scenario: Scenario, folder: Path) -> Made:
    """Run a scenario in a folder.

    Raises:
        ValueError: its rack or its steps can't be used, or its run did not end well.
    """
    (folder / f"{scenario.name}.steps").write_text(library.start[scenario.start] + scenario.steps, "utf-8")
    rack, trace = folder / f"{scenario.name}.toml", folder / f"{scenario.name}{TRACE}"
    rack.write_text(scenario.rack_text(), "utf-8")
    stored_programs(load_rack_file(rack).spec)  # a library is not always the user's own
    job = load_job(str(rack))
    if run_job(job, scenario.run_ms // scenario.scan_ms, RunOptions(trace=trace), quiet=True) != DONE:
        raise ValueError(f"{scenario.name}: the run did not end well")
    with open_trace(trace) as opened:
        return Made(scenario, trace, text_of(scenario, opened), tuple(_wrong(scenario, opened)))


def text_of(scenario: Scenario, trace: Trace) -> str:
    """Return what is told of a recording."""
    contents = Contents(trace, every=False, limit=None, selected=ALL)
    lines = [scenario.says, "", *(line for block in story(contents) for line in plain_lines(block))]
    return "\n".join(lines) + "\n"


def _wrong(scenario: Scenario, trace: Trace) -> Iterator[str]:
    """Yield what is not as the scenario says."""
    fired = [str(event.fields["name"]) for event in trace.events() if event.fields.get("kind") == "rule"]
    started = RULES_OF_START if scenario.start != "none" else frozenset()
    rules = sorted(set(fired) - (started - set(scenario.rules)))
    if rules != sorted(scenario.rules):
        yield f"rules {' '.join(rules) or 'none'} fired, not {' '.join(scenario.rules) or 'none'}"
    *_, last = trace.scans()
    bits, position = _end(last)
    if bits != sorted(scenario.bits):
        yield f"it ends with {' '.join(bits) or 'no bits'}, not {' '.join(scenario.bits) or 'none'}"
    if scenario.position is not None and position != scenario.position:
        yield f"it ends at {position}, not at {scenario.position}"


def _end(scan: Scan) -> tuple[list[str], int | None]:
    """Return the status bits beside MODULE_OK, and the position."""
    inputs = scan.inputs(1)
    names = status_names(inputs[0] & UNSIGNED_MAX, inputs[1] & UNSIGNED_MAX)
    view = StatusView(inputs)
    return sorted(set(names) - {"MODULE_OK"}), None if view.MODE_CONFIG else view.position


def changes(made: Made, folder: Path) -> list[str]:
    """Return how a recording differs from that in the folder; nothing if it does not.

    What only the versions of libraries decide (how well a chunk is compressed, what the metadata
    say of them) is not a difference.
    """
    name = made.scenario.name
    old, text = folder / made.trace.name, folder / f"{name}{TEXT}"
    if not old.exists() or not text.exists():
        return [f"{name}: it is new"]
    before, now = text.read_text("utf-8").splitlines(), made.text.splitlines()
    lines = [*_apart(old, made.trace), *unified_diff(before, now, n=0, lineterm="")]
    return [f"{name}: {line}".rstrip() for line in lines if not line.startswith(("---", "+++", "@@"))]


def _apart(old: Path, new: Path) -> list[str]:
    """Return how two recordings differ."""
    if old.read_bytes() == new.read_bytes():
        return []
    with open_trace(old) as one, open_trace(new) as other:
        found = compare(one, other)
        if not found.same:
            return list(report(found, ("library", "now")))
        if one.head.metadata["layout"] != other.head.metadata["layout"]:
            return ["its schema differs"]
        if list(one.events()) != list(other.events()):
            return ["its events differ"]
        return [] if attached_files(one) == attached_files(other) else ["the files in it differ"]


def left_over(library: Library, folder: Path) -> list[Path]:
    """Return the files of recordings that no scenario makes."""
    names = {scenario.name for scenario in library.scenario}
    files = [path for suffix in (TRACE, TEXT) for path in folder.glob(f"*{suffix}")]
    return sorted(path for path in files if path.stem not in names)


def index_of(library: Library) -> str:
    """Return the index: what each recording shows."""
    lines = [
        "# Golden recordings",
        "",
        "What a 3601 does, a short recording each: `.mcap` for any MCAP tool, `.txt` to read, and the",
        f"scenario in [{SCENARIOS}]({SCENARIOS}). `python tests/tools/golden.py` makes them again and shows",
        "what has changed, see [replay](../../../docs/replay.md).",
    ]
    for group, scenarios in groupby(library.scenario, lambda scenario: scenario.group):
        lines += ["", f"## {group}", "", "| recording | what it shows | rules |", "|---|---|---|"]
        lines += [_index_row(scenario) for scenario in scenarios]
    return "\n".join(lines) + "\n"


def _index_row(scenario: Scenario) -> str:
    name = scenario.name
    files = f"[{name}]({name}{TRACE}) ([text]({name}{TEXT}))"
    return f"| {files} | {scenario.says} | {' '.join(scenario.rules)} |"
