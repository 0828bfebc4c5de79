"""Stores the nonvolatile memory of served controllers in a file.

    {"format": "scanrack memory 1", "controller": "pcl601", "units": [{"address": 1, ...}]}

The file is read at the start and written after each change. A new file is complete before it replaces the old
file. A killed process therefore loses at most the changes from the last 10 ms.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from scanrack.io_images.doors import json_value
from scanrack.io_images.drives.models import MODELS
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.text_limits import TextKind
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pcl601.nonvolatile import Pcl601Memory, Pcl601MemoryReader
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.controllers.pmc006.nonvolatile import Pmc006Memory
from scanrack.runtime.line.wire import ControllerDevice
from scanrack.runtime.modules.drives.nonvolatile import DriveMemory
from scanrack.traces.files.guard import MEMORY, Used, check_output
from scanrack.traces.files.locking import beside, held
from scanrack.traces.files.newfile import naming, new_file

from ..run.served_units import Unit

FORMAT = "scanrack memory 1"

UnitMemory = Pcl601Memory | Pmc006Memory | DriveMemory

MemoryType = TypeVar("MemoryType", Pcl601Memory, Pmc006Memory, DriveMemory)


class _File(BaseModel, Generic[MemoryType]):
    """The contents of the file."""

    model_config = ConfigDict(extra="forbid", strict=True)

    format: Literal["scanrack memory 1"]
    controller: str
    units: Annotated[tuple[MemoryType, ...], Field(strict=False, min_length=1)]


KINDS: Mapping[str, type[_File[Any]]] = {
    "pcl601": _File[Pcl601Memory],
    "pmc006": _File[Pmc006Memory],
    **{model.name: _File[DriveMemory] for model in MODELS.values() if model.flash},
}
"""The model of the file, by controller. Controllers without nonvolatile memory have no entry."""


class ControllerMemory(AbstractContextManager["ControllerMemory"]):
    """The nonvolatile memory of served controllers; its file is locked until the context exits.

    Attributes:
        records: contents of the file, in the order of the units; empty without a file.

    Args:
        controller: name of the controller, as in `KINDS`.
        used: files that must not be replaced.

    Raises:
        ValueError: the file is used for something else, is for another controller, or is damaged; or the
            controller has no nonvolatile memory.
        OSError: another service has locked the file, or its folder can't be written.
    """

    def __init__(self, path: Path, controller: str, used: Used) -> None:
        if controller not in KINDS:
            raise ValueError(f"--memory {path}: the {controller} has no nonvolatile memory")
        self.path, self._controller, self._used = path, controller, used
        target = check_output(path, MEMORY, used)
        with ExitStack() as lock, naming(path, beside(target, "lock")):
            lock.enter_context(held(target))
            self.records = self._read()
            self._lock = lock.pop_all()  # held until the end, unless reading has failed
        self._readers: Sequence[Callable[[], UnitMemory]] = ()

    def _read(self) -> tuple[UnitMemory, ...]:
        """Return the contents of the file; empty if it is missing or empty.

        Raise ValueError if it is damaged.
        """
        if not self.path.exists() or not self.path.stat().st_size:
            return ()
        try:
            data = json_value(read_input_text(self.path, TextKind.MEMORY), TextKind.MEMORY)
            if isinstance(data, dict) and data.get("controller", self._controller) != self._controller:
                raise ValueError(f"this is the memory of a {data['controller']}, not of a {self._controller}")
            units: tuple[UnitMemory, ...] = KINDS[self._controller].model_validate(data).units
        except ValidationError as error:
            first_error = error.errors(include_url=False)[0]
            key = ".".join(map(str, first_error["loc"]))
            problem = first_error["msg"].removeprefix("Value error, ")
            raise ValueError(f"{self.path}: {key}: {problem}") from None
        except ValueError as error:
            raise ValueError(f"{self.path}: {error}") from None
        return units

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def restore(self, units: list[Unit], *, addressed: bool) -> None:
        """Power up the units with the contents of the file, and then follow their changes.

        Args:
            addressed: whether the units keep their addresses instead of using the addresses in the file.

        Raises:
            ValueError: the file has a different number of units.
        """
        self.check_number(len(units))
        for unit, record in zip(units, self.records, strict=False):
            assert not isinstance(record, DriveMemory)
            _restore(record.addressed(unit.address) if addressed else record, unit.device)
        self.follow([_reader(unit.device) for unit in units])

    @property
    def addresses(self) -> list[int]:
        """Addresses of the controllers in the file, in file order; empty without a file and for drives."""
        return [record.address for record in self.records if not isinstance(record, DriveMemory)]

    def check_number(self, units: int) -> None:
        """Raise ValueError if the file exists and has a different number of units."""
        if self.records and len(self.records) != units:
            raise ValueError(f"{self.path}: the file has {len(self.records)} units, but {units} are served")

    def follow(self, readers: Sequence[Callable[[], UnitMemory]]) -> None:
        """Store the values that the readers return, one reader for each unit, at each call of `look`."""
        self._readers = readers

    def look(self) -> None:
        """Write the file if its contents have changed.

        Raises:
            OwnedError: the file may no longer be replaced.
            OSError: the file can't be written; an earlier file is unchanged.
        """
        records = tuple(read() for read in self._readers)
        if records != self.records:
            self._write(records)
            self.records = records

    def _write(self, units: tuple[UnitMemory, ...]) -> None:
        data = {
            "format": FORMAT,
            "controller": self._controller,
            "units": [unit.model_dump(mode="json") for unit in units],
        }
        with new_file(self.path, MEMORY, used=self._used, locked=True) as file:
            file.write(json.dumps(data, indent=1).replace("{\n ", "{", 1) + "\n")


def _restore(memory: UnitMemory, device: ControllerDevice) -> None:
    """Restore the memory of a controller."""
    if isinstance(memory, Pcl601Memory):
        assert isinstance(device, Pcl601)
        memory.restore(device)
    else:
        assert isinstance(memory, Pmc006Memory)
        assert isinstance(device, Pmc006)
        memory.restore(device.controller)


def _reader(device: ControllerDevice) -> Callable[[], UnitMemory]:
    """Return a function that reads a controller's memory."""
    if isinstance(device, Pcl601):
        return Pcl601MemoryReader(device).read
    assert isinstance(device, Pmc006)
    controller = device.controller
    return lambda: Pmc006Memory.of(controller)
