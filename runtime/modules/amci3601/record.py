"""The registry record of the simulated AMCI 3601."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from scanrack.io_images.amci3601.firmware import Firmware
from scanrack.io_images.amci3601.image_form import ImageForm
from scanrack.io_images.amci3601.words import WORDS_3601, Profile
from scanrack.io_images.site import SettingError

from ...loop.module import Module
from ...machine import Machine, MachineSpec
from ..record import ModuleRecord, NamedStatus, Options, Trait

if TYPE_CHECKING:
    from .amci3601_options import Amci3601Options


def make(
    firmware: str,
    machine: MachineSpec,
    seed: int,
    options: Options,
    wiring: str | None,
    profile: Profile = WORDS_3601,
    form: ImageForm | None = None,
) -> Module:
    """Make a simulated 3601 with a machine.

    Args:
        seed: seed of the machine's random numbers.
        options: options of the model, by name.
        wiring: "diagnostic" if the step outputs are wired to the encoder inputs.
        form: form of its images, None for a 3601's.

    Raises:
        ValueError: an unknown firmware or option.
    """
    from .module import Amci3601
    from .restated import Restated3601

    kind = Amci3601 if form is None else partial(Restated3601, form)
    is_wired = wiring == "diagnostic"
    return kind(firmware, Machine(machine, seed), options, diagnostic_wiring=is_wired, profile=profile)


def check_controller(firmware: str, controller: str) -> None:
    """Raise a ValueError if a firmware does not work with a controller.

    With a MicroLogix 1500, a 3601 needs firmware 2.2 [chapter 1, MicroLogix 1500 Configuration].
    """
    if controller == "micrologix" and not Firmware.parse(firmware).micrologix:
        raise SettingError(
            "firmware", f"firmware {firmware} does not run in a MicroLogix rack: must be 2.2 or later"
        )


def _option_table() -> type[Amci3601Options]:
    from .amci3601_options import Amci3601Options

    return Amci3601Options


def stepper(profile: Profile, form: ImageForm | None = None) -> ModuleRecord:
    """Return the record of a module of the 3601's family; its name is its message name in lower case.

    Args:
        form: form of the images; None for a 3601's form. Images of another form are shown with the names of
            their words and bits, because the axis blocks and the number code expect a 3601's words.
    """
    words = profile if form is None else form.words(profile)
    return ModuleRecord(
        name=profile.message.lower(),
        make=partial(make, profile=profile, form=form),
        words=lambda _options: words,
        has_firmware=True,
        status=NamedStatus if form is not None else lambda image, _words: profile.view(image),
        traits=frozenset({Trait.FIRMWARE, Trait.STOPS_ANSWERING, Trait.MACHINE, Trait.SLIPS}),
        check_controller=check_controller,
        option_table=_option_table,
    )


RECORD = stepper(WORDS_3601)
