"""Checks the parts of an installation; reports missing parts and how to install them.

The checks do not import optional libraries, and send nothing over the network.
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
    "prove": "scanrack prove, and a search that reaches branches with a solver",
}
"""The purpose of each extra; `test` and `dev` are for developers of scanrack."""

PROGRAMS: Mapping[str, str] = {
    "tshark": "records lines of real controllers: scanrack import line.pcapng",
    "gtkwave": "shows the files of scanrack export --vcd",
}
"""Optional system programs that scanrack can use."""

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "firefox", "microsoft-edge", "safari")


class Health(StrEnum):
    """Status of one check."""

    GOOD = "ok"
    ABSENT = "absent"
    """An optional part is missing."""
    BROKEN = "broken"
    """A required part is missing."""


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One line of the report; the fields are the keys of `doctor --json`."""

    name: str
    state: Health
    says: str
    remedy: str = ""  # how to fix it, or the benefit of a missing part


def _diagnosis(
    name: str, good_text: str, problem: str, remedy: str, bad_state: Health = Health.ABSENT
) -> Diagnosis:
    """Return a line of the report: `good_text` without a problem, else the problem and its remedy."""
    if problem:
        return Diagnosis(name, bad_state, problem, remedy)
    return Diagnosis(name, Health.GOOD, good_text)


def examined() -> list[Diagnosis]:
    """Examine the installation; return the lines of the report in order."""
    return [diagnosis for check in CHECKS for diagnosis in check()]


def _python() -> Iterator[Diagnosis]:
    """Yield a line about whether scanrack supports this version of Python."""
    oldest, newest = (".".join(map(str, version)) for version in PYTHONS)
    text = f"{platform.python_version()} in {sys.executable}"
    problem = "" if PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1] else text
    yield _diagnosis("Python", text, problem, f"use Python {oldest} to {newest}", Health.BROKEN)


def _package() -> Iterator[Diagnosis]:
    """Yield a line about whether all distributions that scanrack requires are installed."""
    missing = _missing("")
    text = f"{distribution_version(PACKAGE)} in {Path(__file__).parents[2]}"
    problem = missing and f"{text}, without {missing}"
    yield _diagnosis(PACKAGE, text, problem, how_to_install(), Health.BROKEN)


def _extras() -> Iterator[Diagnosis]:
    """Yield a line for each extra: whether it is installed, and its purpose."""
    for extra, purpose in GIVES.items():
        missing = _missing(extra)
        remedy = f"{how_to_install(extra)} for {purpose}"
        yield _diagnosis(f"extra {extra}", purpose, missing and f"{missing} missing", remedy)


def _required(extra: str) -> list[str]:
    """Return the distributions that one of scanrack's extras requires, or scanrack itself for ""."""
    project = own_project()
    if project is not None:
        rows = project["optional-dependencies"][extra] if extra else project["dependencies"]
    else:
        expected = f'extra == "{extra}"' if extra else ""
        parts = [row.replace("'", '"').partition(";") for row in requires(PACKAGE) or ()]
        rows = [requirement for requirement, _, marker in parts if marker.strip() == expected]
    return [re.split(r"[<>=!~\[ ]", row, maxsplit=1)[0] for row in rows]


def _missing(extra: str) -> str:
    """Return the required distributions that are not installed, as text; see `_required`."""
    return ", ".join(distribution for distribution in _required(extra) if not _installed(distribution))


def _installed(distribution: str) -> bool:
    return distribution_version(distribution) != UNKNOWN


def _ports() -> Iterator[Diagnosis]:
    """Yield a line for each serial port: whether the user may open it. Without ports, yield one line."""
    from serial.tools.list_ports import comports

    devices = sorted(port.device for port in comports())
    if not devices:
        remedy = "plug in the serial adapter of a device; simulated devices need none"
        yield Diagnosis("serial ports", Health.ABSENT, "none found", remedy)
    for device in devices:
        problem = "" if os.access(device, os.R_OK | os.W_OK) else f"{device} can't be opened"
        remedy = 'add your user to its group, such as "dialout", and log in again'
        yield _diagnosis("serial port", device, problem, remedy)


def _real_time() -> Iterator[Diagnosis]:
    """Yield lines about the real-time permissions of the system. They are requested and released at once."""
    with real_time() as outcomes:
        permissions = list(outcomes)
    for permission in permissions:
        state = Health.ABSENT if permission.refusal else Health.GOOD
        text = f"{permission.name}: {permission.refusal}" if permission.refusal else permission.name
        yield Diagnosis("real time", state, text, permission.advice)


def _browser() -> Iterator[Diagnosis]:
    """Yield a line about the browser for the `scanrack watch` page."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), "")
    if sys.platform in ("darwin", "win32"):  # their browsers are not on the path
        browser = browser or "the system's"
    remedy = "install one, such as Firefox or Chromium, for the page of scanrack watch"
    yield _diagnosis("browser", browser, "" if browser else "none found", remedy)


def _programs() -> Iterator[Diagnosis]:
    """Yield a line about the location of each optional system program."""
    for name, purpose in PROGRAMS.items():
        path = shutil.which(name) or ""
        problem = "" if path else "not on the path"
        yield _diagnosis(name, path, problem, f"a package of your system; it {purpose}")


CHECKS: tuple[Callable[[], Iterator[Diagnosis]], ...] = (
    _python,
    _package,
    _extras,
    _ports,
    _real_time,
    _browser,
    _programs,
)
