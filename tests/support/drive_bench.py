"""A networked drive for the benches of axes and blocks: its configuration as that of `bench3601`, and a link.

Inputs: 1 is home, 2 emergency stop; an ANF2 has home and both limits. Starting speed 1,000 steps/s.
"""

from __future__ import annotations

from scanrack.io_images.drives import models
from scanrack.io_images.image import Image
from scanrack.runtime import ModuleFault
from scanrack.runtime.machine import Machine
from scanrack.runtime.modules.drives.drive import DriveUnit
from typing_extensions import override

MODELS, Layout = models.MODELS, models.Layout

HOME, ESTOP, CAPTURE, STOP_JOG, CW_LIMIT = 7, 6, 5, 4, 1
BINARY, BINARY_LOW = 0x0300, 0x0700

ROLES = {HOME: "home", ESTOP: "estop", CAPTURE: "capture", STOP_JOG: "external", CW_LIMIT: "cw_limit"}


def drive_words(model: str, *, inputs: tuple[int, int] = (HOME, ESTOP), format: int = 0) -> tuple[int, ...]:
    """Return ten configuration words; both inputs are active when on."""
    if MODELS[model].layout is Layout.ANF2:
        return (0x807C, 0x001C, 0, 1_000, 0, 0, 0, 0, 0, 0)
    first, second = inputs
    return (0x8000 | first | second << 3, 0x0003 | format, 1, 0, 2_000, 0, 0, 50, 28, 0)


class LinkedDrive(DriveUnit):
    """A drive whose link a test can lose: the inputs stand still then, and words do not arrive."""

    linked = True

    def __init__(self, model: str, machine: Machine, inputs: tuple[int, int] = (HOME, ESTOP)) -> None:
        is_anf2 = MODELS[model].layout is Layout.ANF2
        wired = {} if is_anf2 else {"in1": ROLES[inputs[0]], "in2": ROLES[inputs[1]]}
        super().__init__(MODELS[model], machine, wired)

    def inject(self, fault: ModuleFault | None) -> None:
        """Lose the link, or find it again."""
        self.linked = fault is None
        self._touch()

    @override
    def update(self, now_ns: int, outputs: Image) -> Image:
        if self.linked:
            return super().update(now_ns, outputs)
        self.advance(now_ns)
        return self._image
