"""The path to a 3601 over a CompactLogix or another rack's tag server. Requires pycomm3, extra `conform`."""

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
        """Return the response for a tag, or a list of responses, each with `value` and `error`."""

    def write(self, *values: Any) -> Any:
        """Write pairs of tag and value; return their responses."""

    def close(self) -> Any:
        """Close the connection."""


@dataclass(frozen=True, slots=True)
class ModuleTags:
    """The tags of the module in the user's controller.

    Attributes:
        slot: slot of the module, as in `Local:SLOT:I` and `Local:SLOT:O`.
        counter: tag that counts scans; "" if there is none.
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
        ValueError: the path is invalid, pycomm3 is missing, or no controller responds.
    """
    match = PATH.fullmatch(path)
    if match is None:
        raise ValueError(f"--path: invalid path {path!r}; must be HOST[:PORT][,SLOT]")
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
        raise ValueError(f"{path}: no Logix controller responds: {error}") from None
    connected: TagClient = client
    return connected


def is_real(client: TagClient) -> bool:
    """Whether a controller may move a real axis: its product name does not contain scanrack."""
    return NOT_REAL not in str(client.info.get("product_name", "")).lower()


def product_of(client: TagClient) -> str:
    """Return the product name and revision of a controller; they do not identify its owner."""
    revision = client.info.get("revision") or {}
    numbers = [str(revision[key]) for key in ("major", "minor") if key in revision]
    return " ".join([str(client.info.get("product_name", "")), ".".join(numbers)]).strip()


class LogixPath:
    """A module that a controller operates, see `playing.ModulePath`.

    Raises:
        ValueError: the controller does not have the module.
        OSError: the controller does not have the counter.
    """

    def __init__(self, client: TagClient, tags: ModuleTags) -> None:
        """Find the tags of the module's input words, and read the counter if there is one."""
        self._client, self._tags = client, tags
        self._inputs = f"Local:{tags.slot}:I.Data{{{WORDS}}}"
        self._outputs = f"Local:{tags.slot}:O.Data{{{WORDS}}}"
        self._first_count: int | None = None
        self._last_ns = 0  # time of the counter when it was last read
        self._input_tags: tuple[str, ...] = (self._inputs,)
        probe = client.read(self._inputs)
        if probe.error:  # with the manufacturer's profile, each word is a tag
            self._input_tags = tuple(f"Local:{tags.slot}:I.Data{word}" for word in range(WORDS))
            if any(response.error for response in client.read(*self._input_tags)):
                raise ValueError(f"slot {tags.slot}: no Local:{tags.slot}:I of a 3601: {probe.error}")
        if tags.counter:
            self._count_ns()

    def now_ns(self) -> int:
        """Return the time of this machine's clock, or the time of the counter when it was last read, ns."""
        return self._last_ns if self._tags.counter else time.monotonic_ns()

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
        """Write tags; return the window in which they changed."""
        low_ns = self._count_ns() if self._tags.counter else time.monotonic_ns()
        _values(self._client.write(*values))
        high_ns = self._count_ns() + self._tags.period_ns if self._tags.counter else time.monotonic_ns()
        return Window(low_ns, high_ns)

    def read(self) -> SeenImage:
        """Read the input words, in one packet with the counter.

        Raises:
            OSError: the connection is lost.
        """
        tags = [*self._input_tags, self._tags.counter] if self._tags.counter else list(self._input_tags)
        low_ns = time.monotonic_ns()
        responses = self._client.read(*tags)
        high_ns = time.monotonic_ns()
        values = _values(responses)
        if self._tags.counter:
            low_ns = self._time_of_count(values.pop())
            high_ns = low_ns + self._tags.period_ns
        words = values[0] if len(self._input_tags) == 1 else values
        return SeenImage(Window(low_ns, high_ns), tuple(words))

    def _count_ns(self) -> int:
        """Read the counter; return its time, ns."""
        return self._time_of_count(_values(self._client.read(self._tags.counter))[0])

    def _time_of_count(self, count: int) -> int:
        """Return the time of a count, ns. The time continues even if the counter restarts."""
        if self._first_count is None:
            self._first_count = count
        periods = self._last_ns // self._tags.period_ns
        further = (count - self._first_count - periods) % (1 << COUNTER_BITS)
        self._last_ns = (periods + further) * self._tags.period_ns
        return self._last_ns

    def close(self) -> None:
        """Close the connection."""
        with suppress(Exception):
            self._client.close()


def _values(responses: Any) -> list[Any]:
    """Return the values in one or more responses; raise OSError if a response has an error."""
    listed = responses if isinstance(responses, list) else [responses]
    for response in listed:
        if response.error:
            raise OSError(f"{response.tag}: {response.error}")
    return [response.value for response in listed]


def wiring_of(pairs: list[str]) -> dict[InputBit, str]:
    """Return the tag that energizes each input, from pairs such as `ESTOP=Local:2:O.Data.0`.

    Raises:
        ValueError: a text is not a pair.
    """
    names = {str(bit.name): bit for bit in InputBit}
    wiring: dict[InputBit, str] = {}
    for pair in pairs:
        name, equals, tag = pair.partition("=")
        if not equals or not tag or name.upper() not in names:
            raise ValueError(
                f"--wire: invalid {pair!r}; must be INPUT=TAG, with an input of {', '.join(names)}"
            )
        wiring[names[name.upper()]] = tag
    return wiring


def counter_of(text: str | None) -> tuple[str, int]:
    """Return the tag and period in `TAG:MS`; for None, an empty tag.

    Raises:
        ValueError: the text is invalid.
    """
    if text is None:
        return "", 0
    tag, colon, period = text.rpartition(":")
    if not colon or not tag or not re.fullmatch(r"\d+(\.\d+)?", period) or not 0 < float(period) <= 1000:
        raise ValueError(f"--counter: invalid {text!r}; must be TAG:MS, such as ConformScan:2")
    return tag, exact_ns(float(period), "ms", f"--counter {text}: a period")
