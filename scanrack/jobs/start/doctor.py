"""Reports what an installation has, what it lacks, and how to fix it.

The checks import nothing and send nothing over the network.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from importlib.metadata import requires
from pathlib import Path

from scanrack.io_images.installing import how_to_install
from scanrack.io_images.versions import UNKNOWN, distribution_version, own_project
from scanrack.runtime.loop.realtime import real_time

PACKAGE = "scanrack"
PYTHONS = ((3, 11), (3, 14))
"""The oldest and the newest Python version that scanrack supports."""

GIVES: Mapping[str, str] = {
    "check": "other solvers that check proofs: scanrack prove --check",
    "cluster": "searches on a cluster: scanrack fuzz --dask",
    "conform": "scanrack conform: a real 3601 against its manual",
    "editor": "diagnostics, hover and completion in editors: scanrack editor lsp",
    "frames": "recordings as frames of pandas and Polars: trace.to_pandas()",
    "opcua": "tags over OPC UA: scanrack run --server opc-ua",
    "parquet": "scanrack export --parquet",
    "plot": "charts as PNG and SVG: scanrack plot",
    "prove": "scanrack prove, and a search that solves its way on",
}
"""The purpose of each extra; `test` and `dev` are for developers of scanrack."""

PROGRAMS: Mapping[str, str] = {
    "tshark": "records lines of real controllers: scanrack import line.pcapng",
    "gtkwave": "shows what scanrack export --vcd writes",
}
"""Optional system programs that scanrack can use."""

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "firefox", "microsoft-edge", "safari")


class Health(StrEnum):
    """Status of one check."""

    GOOD = "ok"
    ABSENT = "absent"
    """Something optional is missing."""
    BROKEN = "broken"
    """Something required is missing."""


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One line of the report."""

    name: str
    state: Health
    says: str
    mend: str = ""  # how to fix it, or what it would add


def _diagnosis(
    name: str, text: str, lack: str = "", mend: str = "", state: Health = Health.ABSENT
) -> Diagnosis:
    """Return a line of the report: `text`, or `lack` with its state and its remedy."""
    return Diagnosis(name, state, lack, mend) if lack else Diagnosis(name, Health.GOOD, text)


def examined() -> list[Diagnosis]:
    """Examine the installation; return the lines of the report in order."""
    return [check for part in PARTS for check in part()]


def _python() -> Iterator[Diagnosis]:
    oldest, newest = (".".join(map(str, version)) for version in PYTHONS)
    fits = PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]
    mend = "" if fits else f"use Python {oldest} to {newest}"
    text = f"{platform.python_version()} in {sys.executable}"
    yield Diagnosis("Python", Health.GOOD if fits else Health.BROKEN, text, mend)


def _package() -> Iterator[Diagnosis]:
    missing = _missing("")
    text = f"{distribution_version(PACKAGE)} in {Path(__file__).parents[2]}"
    lack = missing and f"{text}, without {missing}"
    yield _diagnosis(PACKAGE, text, lack, how_to_install(), Health.BROKEN)


def _extras() -> Iterator[Diagnosis]:
    for extra, gives in GIVES.items():
        missing = _missing(extra)
        mend = f"{how_to_install(extra)} for {gives}"
        yield _diagnosis(f"extra {extra}", gives, missing and f"{missing} missing", mend)


def _required(extra: str) -> list[str]:
    """Return the distributions that scanrack or one of its extras requires."""
    expected = f'extra == "{extra}"' if extra else ""
    project, names = own_project(), []
    if project is not None:
        rows = project["optional-dependencies"][extra] if extra else project["dependencies"]
        return [re.split(r"[<>=!~\[ ]", row, maxsplit=1)[0] for row in rows]
    for row in requires(PACKAGE) or ():
        name, _, marker = row.replace("'", '"').partition(";")
        if marker.strip() == expected:
            names.append(re.split(r"[<>=!~\[ ]", name, maxsplit=1)[0])
    return names


def _missing(extra: str) -> str:
    """Return the required distributions that are not installed, see `_required`."""
    return ", ".join(requirement for requirement in _required(extra) if not _installed(requirement))


def _installed(distribution: str) -> bool:
    return distribution_version(distribution) != UNKNOWN


def _ports() -> Iterator[Diagnosis]:
    from serial.tools.list_ports import comports

    devices = sorted(port.device for port in comports())
    if not devices:
        mend = "plug in the adapter of a controller; simulated ones need none"
        yield Diagnosis("serial ports", Health.ABSENT, "there is none", mend)
    for device in devices:
        lack = "" if os.access(device, os.R_OK | os.W_OK) else f"{device} can't be opened"
        mend = 'add your user to its group, such as "dialout", and log in again'
        yield _diagnosis("serial port", device, lack, mend)


def _real_time() -> Iterator[Diagnosis]:
    with real_time() as outcomes:
        granted = list(outcomes)
    for permission in granted:
        state = Health.ABSENT if permission.refusal else Health.GOOD
        text = f"{permission.name}: {permission.refusal}" if permission.refusal else permission.name
        yield Diagnosis("real time", state, text, permission.advice)


def _browser() -> Iterator[Diagnosis]:
    browser = next(filter(None, map(shutil.which, BROWSERS)), "")
    if sys.platform in ("darwin", "win32"):  # no browser program is on the path
        browser = browser or "the system's"
    mend = "install one, such as Firefox or Chromium: scanrack watch shows its page in it"
    yield _diagnosis("browser", browser, "" if browser else "none is found", mend)


def _programs() -> Iterator[Diagnosis]:
    for name, gives in PROGRAMS.items():
        path = shutil.which(name) or ""
        lack = "" if path else "not on the path"
        yield _diagnosis(name, path, lack, f"a package of your system; it {gives}")


PARTS: tuple[Callable[[], Iterator[Diagnosis]], ...] = (
    _python,
    _package,
    _extras,
    _ports,
    _real_time,
    _browser,
    _programs,
)
