"""The bench of `scanrack drive pcl601-adapter`: an image bench with a line and a controller behind it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ..adapters.pcl601.module import Pcl601Adapter
from .image_bench import ImageBench, machine_for
from .requests import TABLES, Bench, Request, Strict, Tables, read

Count = Annotated[int, Field(ge=1, le=1_000_000, strict=True)]


class LinkFault(Strict):
    """What befalls the next replies."""

    drop_next: Count | None = None
    corrupt_next: Count | None = None


class AdapterRequest(Request):
    """One request to an adapter."""

    link: Literal["down", "up"] | LinkFault | None = None
    device: Literal["power_cycle"] | None = None

    @model_validator(mode="after")
    def _no_firmware(self) -> AdapterRequest:
        if self.new is not None and {"firmware", "wiring"} & self.new.model_fields_set:
            raise ValueError("new: firmware and wiring are for target amci3601 only")
        return self


ADAPTER_TABLES: Tables = TABLES | {(): AdapterRequest, ("link",): LinkFault}


class AdapterBench(ImageBench):
    """An adapter with its simulated controller on the bench."""

    module: Pcl601Adapter

    def answer_line(self, line: str) -> dict[str, Any]:
        """Carry out one line.

        Raises:
            RequestError: it can't be taken; nothing has changed.
        """
        return self.answer(read(line, AdapterRequest, ADAPTER_TABLES))

    def _befall(self, request: Request) -> None:
        assert isinstance(request, AdapterRequest)
        line = self.module.controller.line
        if request.link == "down":
            line.take_down()
        elif request.link == "up":
            line.put_up()
        elif isinstance(request.link, LinkFault):
            line.faults.drop_next += request.link.drop_next or 0
            line.faults.corrupt_next += request.link.corrupt_next or 0
        if request.device is not None:
            self.module.cycle_device()


def pcl601_adapter_on_bench(options: Bench) -> Pcl601Adapter:
    """Make an adapter for the options of a fresh bench."""
    return Pcl601Adapter(machine_for(options), options.options)


def pcl601_adapter_bench() -> AdapterBench:
    """Return the bench of `drive pcl601-adapter`."""
    return AdapterBench(pcl601_adapter_on_bench)
