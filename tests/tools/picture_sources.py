"""The pictures of the docs, each with the program that it shows; docs/images/sources.txt has digests."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "docs" / "images"
DIGESTS = IMAGES / "sources.txt"
REMEDY = "draw it again, then python -m tests.tools.generate pictures"


class Source(NamedTuple):
    """What a picture shows.

    Attributes:
        files: program and rack, from the root; or a page that has them.
        drawn: the command that draws it.
    """

    files: tuple[str, ...]
    drawn: str


def _page(example: str, *files: str) -> Source:
    return Source(
        tuple(f"examples/{example}/{file}" for file in files), "python tests/tools/watch_pictures.py"
    )


def _chart(folder: str, program: str, rack: str, options: str = "") -> Source:
    files = (f"examples/{folder}/{program}", f"examples/{folder}/{rack}")
    return Source(
        files, f"scanrack run {files[1]} --record a.mcap; scanrack plot a.mcap {options}--out PICTURE"
    )


def _sequence(program: str) -> Source:
    return _chart("sequences", f"{program}.py", f"{program}.toml")


_FEEDER = _page("feeder", "feeder.rung", "feeder.toml")
_PANEL = _page("three_stations_panel", "line.rung", "line.toml")
_STATIONS = _chart("three_stations", "line.py", "line.toml")
_TAGS = "--slot 2 --slot 3 --tag Step --tag Dwell --tag Run "

PICTURES = {
    "feeder-rungs.svg": Source(
        ("examples/feeder/feeder.rung",),
        "scanrack ladder examples/feeder/feeder.rung --width 80 --svg PICTURE, its first rungs",
    ),
    "fuzzing.png": Source(("docs/fuzzing.md",), "the page of the chart that its five minutes write"),
    "hmi-panel.png": _page("hmi", "feeder.rung", "panel.html"),
    "indexer.png": _chart("l5x", "indexer.L5X", "indexer.toml", "--tag Run --tag Step --tag Dwell "),
    "mix-chart.svg": Source(
        ("examples/l5x/mixer.L5X",),
        r"scanrack ladder examples/l5x/mixer.toml --routine '\MainProgram.Sequence' --svg PICTURE",
    ),
    "one-move.png": _STATIONS,
    "page.png": _STATIONS,
    "panel.png": _chart("three_stations_panel", "line.rung", "line.toml", _TAGS),
    "vscode-debugger.png": Source(
        ("examples/feeder/feeder.rung", "editors/vscode/package.json"),
        "the extension in code-server 4.100 at 1280 x 800: a breakpoint at Homing, continue, step back",
    ),
    "sequence-blend.png": _sequence("blend_path"),
    "sequence-jog.png": _sequence("jog_panel"),
    "sequence-labeller.png": _sequence("labeller"),
    "sequence-stations.png": _sequence("stations"),
    "sequence-zone.png": _sequence("shared_zone"),
    "three-stations.png": _STATIONS,
    "watch-dark.png": _PANEL,
    "watch-operator-panel.png": _page("feeder", "feeder.rung", "feeder.toml", "feeder.panel"),
    "watch-panel.png": _PANEL,
    "watch-past.png": _FEEDER,
    "watch.gif": _PANEL,
    "watch.png": _FEEDER,
}


def digests() -> dict[str, str]:
    """Return the digest of what each picture shows, as the files are now."""
    return {name: _digest(source.files) for name, source in PICTURES.items()}


def text() -> str:
    """Return the file of digests as it should be."""
    return "".join(f"{name} {each}\n" for name, each in digests().items())


def _digest(files: tuple[str, ...]) -> str:
    found = hashlib.sha256()
    for file in files:
        found.update(_shown(ROOT / file))
    return found.hexdigest()[:16]


def _shown(file: Path) -> bytes:
    """Return the bytes that a picture can depend on: of a page its first three files."""
    text = file.read_bytes().replace(b"\r\n", b"\n")
    return text if file.suffix != ".md" else b"\n".join(text.split(b"\n```")[1:6:2])


def outdated() -> Iterator[str]:
    """Yield the pictures whose program is another than when they were drawn."""
    kept = dict(line.split() for line in DIGESTS.read_text(encoding="utf-8").splitlines())
    for name, digest in digests().items():
        if kept.get(name) != digest:
            yield f"{name}: {', '.join(PICTURES[name].files)} changed: {PICTURES[name].drawn}"
