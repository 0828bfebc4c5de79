"""The bench of `scanrack drive` for adapters: an image bench with a line and a simulated controller."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator
from scanrack.runtime.modules.adapters.module import SimulatedAdapter

from .image_bench import ImageBench
from .requests import Request, Strict

Count = Annotated[int, Field(ge=1, le=1_000_000, strict=True)]


class LinkFault(Strict):
    """Faults in the next replies."""

    drop_next: Count | None = None
    corrupt_next: Count | None = None


class AdapterRequest(Request):
    """A request to an adapter. `wiring` has no effect, because no controller counts its own steps."""

    link: Literal["down", "up"] | LinkFault | None = None
    device: Literal["power_cycle"] | None = None

    @model_validator(mode="after")
    def _no_firmware(self) -> AdapterRequest:
        if self.new is not None and "firmware" in self.new.model_fields_set:
            raise ValueError("new: firmware is for target amci3601 only")
        return self


class AdapterBench(ImageBench):
    """An adapter with its simulated controller on the bench."""

    requests = AdapterRequest
    module: SimulatedAdapter[Any]

    def _act_on_line(self, request: Request) -> None:
        """Open or restore the line, add faults to its next replies, or power-cycle its device."""
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
