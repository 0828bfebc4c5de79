"""Data from outside: consumed tags before a scan, and the replies of messages.

    producer   5 5 5 5 7 7 7 7 7 9         a consumed tag gets a sample for each multiple of the RPI,
    RPI        |       |       |            before the first scan at or after it
    consumer   5       5       7

A member of type CONNECTION_STATUS has the producer's RunMode, and ConnectionFaulted. The data of a broken
connection does not change [1756-PM011, "Produced and Consumed Tags"].
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from scanrack.io_images.dataclass import dataclass

from ..model.errors import LadderError, Problem
from ..model.operands import Group
from ..model.stubs import RPI_NS, Ending, Partner, Remote, Sample, Sampler, Stub
from ..model.tags import Leaf, tag_in
from ..model.types import LINT, Structure
from ..state.lowered import LoweredProgram
from ..state.memory import Memory
from .view import Tags

ALONE = Remote()

STATUS = "CONNECTION_STATUS"
"""Type of the member that has the state of a connection."""


@dataclass(frozen=True, slots=True)
class Connection:
    """A consumed tag and its partner."""

    tag: str
    sampler: Sampler
    rpi_ns: int
    samples: Leaf  # number of the samples so far; 0 before the first
    status: str  # its CONNECTION_STATUS, "" without one

    def update(self, engine: Any, tags: Tags) -> None:
        """Take a sample if one is due."""
        number = engine.now_ns // self.rpi_ns + 1
        if engine.memory.read(self.samples) != number:
            engine.memory.write(self.samples, 0, number)
            apply_sample(tags, self.tag, self.status, self.sampler(engine.now_ns))


def apply_sample(tags: Tags, tag: str, status: str, sample: Sample) -> None:
    """Set a tag to a sample; raise a ValueError if the value does not fit."""
    if sample.value is not None and not sample.faulted:
        set_tag(tags, tag, sample.value)
    if status:
        running = sample.running and not sample.faulted
        tags[status] = {"RunMode": running, "ConnectionFaulted": sample.faulted}


def set_tag(tags: Tags, tag: str, value: Any) -> None:
    """Set a tag.

    A list sets the elements from a subscript in `tag` on. A single value sets the first element of an array.
    """
    if isinstance(value, list) and tag.endswith("]"):
        name, _, subscript = tag[:-1].rpartition("[")
        if subscript.isdecimal():
            for index, item in enumerate(value, int(subscript)):
                tags[f"{name}[{index}]"] = item
            return
    if not isinstance(value, (list, dict, str)) and isinstance(tags[tag], list):
        tag = f"{tag}[0]"
    tags[tag] = value


def connect(
    lowered: LoweredProgram, stubs: Mapping[str, Stub], remotes: Mapping[str, Remote]
) -> Iterator[Problem]:
    """Connect consumed tags and replies before the memory exists; yield problems with their stubs."""
    tags = Tags(lowered, None)  # type: ignore[arg-type]  # names are resolved without memory
    for name, stub in stubs.items():
        try:
            if isinstance(stub, Partner):
                lowered.connections.append(_connection(lowered, tags, name, stub, remotes.get(name, ALONE)))
            elif isinstance(stub, Ending) and stub.reply is not None:
                target = stub.to or remotes.get(name, ALONE).tag
                if not target:
                    raise LadderError('no tag for the data; name one, such as to = "Data[0]"')
                tags.where(target)
                lowered.replies[name] = target, stub.reply.open("", RPI_NS)
        except (LadderError, ValueError) as error:
            yield Problem(f"stub {name}", "", str(error), "correct it in [stubs]")


def _connection(lowered: LoweredProgram, tags: Tags, name: str, stub: Partner, remote: Remote) -> Connection:
    """Return the connection of a consumed tag; its status is the first member of type `STATUS`."""
    resolved = tags.where(name)
    rpi_ns = stub.rpi_ns or remote.rpi_ns or RPI_NS
    kind = resolved.type if isinstance(resolved, Group) and not resolved.dims else None
    members = kind.members if isinstance(kind, Structure) else ()
    status_member = next((member.name for member in members if member.type.name.upper() == STATUS), "")
    samples = lowered.layout.hidden(f"~{name}.taken", LINT)
    status = f"{name}.{status_member}" if status_member else ""
    return Connection(name, stub.source.open(remote.tag, rpi_ns), rpi_ns, samples, status)


def wrong_values(lowered: LoweredProgram, memory: Memory) -> Iterator[Problem]:
    """Yield the partners with a first value that does not fit; leave the memory unchanged."""
    tags = Tags(lowered, memory)
    samplers = [(connection.tag, connection.sampler) for connection in lowered.connections]
    for tag, sampler in (*samplers, *lowered.replies.values()):
        try:
            resolved = tags.where(tag)
            whole_tag = tag_in(resolved.path if isinstance(resolved, Group) else resolved.leaf.path)
            old_value = tags[whole_tag]
            apply_sample(tags, tag, "", sampler(0))
            tags[whole_tag] = old_value
        except (LadderError, ValueError) as error:
            yield Problem(f"data for {tag}", "", str(error), "give a value that fits its type")


def receive(lowered: LoweredProgram, memory: Memory, path: str, now_ns: int) -> None:
    """Set a message's tag to its reply."""
    reply = lowered.replies.get(path.upper())
    if reply is not None:
        tag, sampler = reply
        apply_sample(Tags(lowered, memory), tag, "", sampler(now_ns))


def updates_of(lowered: LoweredProgram) -> tuple[Callable[[Any, bool], None], ...]:
    """Return the function that fills consumed tags before a scan; empty without consumed tags."""

    def update(engine: Any, _first: bool) -> None:
        for connection in lowered.connections:
            connection.update(engine, engine.tags)

    return (update,) if lowered.connections else ()
