"""The path to a 3601 over a CompactLogix or another rack's tag server. Needs pycomm3, extra `conform`."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol

from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.image import WORDS
from scanrack.io_images.installing import how_to_install
from scanrack.io_images.times import exact_ns

from ..moments import ImageWords, SeenImage, Window

PATH = re.compile(r"(?P<host>[^,\s/]+?)(:(?P<port>\d{1,5}))?(,(?P<slot>\d{1,2}))?")
COUNTER_BITS = 32
NOT_REAL = "scanrack"
"""Part of the product name of a server that moves no real axis."""


class TagClient(Protocol):
    """The part of `pycomm3.LogixDriver` that is used."""

    info: Mapping[str, Any]

    def read(self, *tags: str) -> Any:
        """Return the answer for a tag, or a list of answers, each with `value` and `error`."""

    def write(self, *values: Any) -> Any:
        """Write pairs of tag and value, and return their answers."""

    def close(self) -> Any:
        """Close the connection."""


@dataclass(frozen=True, slots=True)
class ModuleTags:
    """The tags of the module in the user's controller.

    Attributes:
        slot: slot of the module, as in `Local:SLOT:I` and `Local:SLOT:O`.
        counter: tag that counts scans; "" without one.
        period_ns: time between counts, ns.
        wiring: inputs that are wired to outputs, each with the BOOL tag that energizes it.
    """

    slot: int = 1
    counter: str = ""
    period_ns: int = 0
    wiring: Mapping[InputBit, str] | None = None


def connect(path: str) -> TagClient:
    """Return a connection to `HOST[:PORT][,SLOT]`.

    Raises:
        ValueError: the path has another form, pycomm3 is missing, or there is no answer.
    """
    match = PATH.fullmatch(path)
    if match is None:
        raise ValueError(f"--path {path!r} is not allowed: HOST[:PORT][,SLOT]")
    try:
        library: Any = import_module("pycomm3")
    except ImportError:
        raise ValueError(f"pycomm3 is missing: {how_to_install('conform')}") from None
    host = match["host"] + (f":{match['port']}" if match["port"] else "")
    client = library.LogixDriver(f"{host}/{match['slot'] or 0}", init_tags=False)
    try:
        client.open()
        client.get_tag_list()
    except (library.PycommError, OSError) as error:
        raise ValueError(f"{path}: no Logix controller answers: {error}") from None
    connected: TagClient = client
    return connected


def is_real(client: TagClient) -> bool:
    """Whether a controller may move a real axis: its product name is not that of scanrack."""
    return NOT_REAL not in str(client.info.get("product_name", "")).lower()


def product_of(client: TagClient) -> str:
    """Return the product name and revision of a controller, which do not identify its owner."""
    revision = client.info.get("revision") or {}
    parts = [str(revision[key]) for key in ("major", "minor") if key in revision]
    return " ".join([str(client.info.get("product_name", "")), ".".join(parts)]).strip()


class LogixPath:
    """A module that a controller operates, see `playing.ModulePath`.

    Raises:
        ValueError: the controller does not have that module or counter.
    """

    def __init__(self, client: TagClient, tags: ModuleTags) -> None:
        self._client, self._tags = client, tags
        self._inputs = f"Local:{tags.slot}:I.Data{{{WORDS}}}"
        self._outputs = f"Local:{tags.slot}:O.Data{{{WORDS}}}"
        self._origin: int | None = None
        self._last = 0
        probe = client.read(self._inputs)
        if probe.error:  # the manufacturer's profile has words of its own
            self._parts: tuple[str, ...] = tuple(f"Local:{tags.slot}:I.Data{word}" for word in range(WORDS))
            answers = client.read(*self._parts)
            if any(answer.error for answer in answers):
                raise ValueError(f"slot {tags.slot}: no Local:{tags.slot}:I of a 3601: {probe.error}")
        else:
            self._parts = (self._inputs,)
        if tags.counter:
            self._count()

    def now_ns(self) -> int:
        """Return the time of this machine's clock, or the time of the counter when it was last read, ns."""
        return self._last if self._tags.counter else time.monotonic_ns()

    def write(self, words: ImageWords) -> Window:
        """Set the output words; see `playing.ModulePath`.

        Raises:
            OSError: the controller refuses the words, or the connection is lost.
        """
        return self._timed((self._outputs, list(words)))

    def operate(self, inputs: int) -> Window:
        """Set the tags that energize the wired inputs.

        Raises:
            OSError: see `write`.
        """
        wiring = self._tags.wiring or {}
        return self._timed(*((tag, bool(inputs & bit)) for bit, tag in wiring.items()))

    def _timed(self, *values: tuple[str, Any]) -> Window:
        low = self._count() if self._tags.counter else time.monotonic_ns()
        answers = self._client.write(*values)
        for answer in answers if isinstance(answers, list) else [answers]:
            _checked(answer)
        high = self._count() + self._tags.period_ns if self._tags.counter else time.monotonic_ns()
        return Window(low, high)

    def read(self) -> SeenImage:
        """Read the input words, in one packet with the counter.

        Raises:
            OSError: the connection is lost.
        """
        names = [*self._parts, self._tags.counter] if self._tags.counter else list(self._parts)
        low = time.monotonic_ns()
        answers = self._client.read(*names)
        high = time.monotonic_ns()
        answers = answers if isinstance(answers, list) else [answers]
        values = [_checked(answer) for answer in answers]
        if self._tags.counter:
            low = self._at(values.pop())
            high = low + self._tags.period_ns
        return SeenImage(Window(low, high), tuple(values[0] if len(self._parts) == 1 else values))

    def _count(self) -> int:
        return self._at(_checked(self._client.read(self._tags.counter)))

    def _at(self, count: int) -> int:
        """Return the time of a count, ns. The time keeps running even if the counter restarts."""
        if self._origin is None:
            self._origin = count
        reached = self._last // self._tags.period_ns
        cycles = (count - self._origin - reached) % (1 << COUNTER_BITS)
        self._last = (reached + cycles) * self._tags.period_ns
        return self._last

    def close(self) -> None:
        """Close the connection."""
        with suppress(Exception):
            self._client.close()


def _checked(answer: Any) -> Any:
    if answer.error:
        raise OSError(f"{answer.tag}: {answer.error}")
    return answer.value


def wiring_of(pairs: list[str]) -> dict[InputBit, str]:
    """Return the tag that energizes each input, from pairs such as `ESTOP=Local:2:O.Data.0`.

    Raises:
        ValueError: a text is not such a pair.
    """
    names = {str(bit.name): bit for bit in InputBit}
    wiring: dict[InputBit, str] = {}
    for pair in pairs:
        name, equals, tag = pair.partition("=")
        if not equals or not tag or name.upper() not in names:
            raise ValueError(f"--wire {pair!r} is not allowed: INPUT=TAG, the input of {', '.join(names)}")
        wiring[names[name.upper()]] = tag
    return wiring


def counter_of(text: str | None) -> tuple[str, int]:
    """Return the tag and period of `TAG:MS`; for None, an empty tag.

    Raises:
        ValueError: the text has another form.
    """
    if text is None:
        return "", 0
    tag, colon, period = text.rpartition(":")
    if not colon or not tag or not re.fullmatch(r"\d+(\.\d+)?", period) or not 0 < float(period) <= 1000:
        raise ValueError(f"--counter {text!r} is not allowed: TAG:MS, such as ConformScan:2")
    return tag, exact_ns(float(period), "ms", f"--counter {text}: a period")
