"""The targets of `scanrack drive`: every registered module, and the controllers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.drives.models import MODELS, Model
from scanrack.runtime.modules.record import ModuleRecord, Trait
from scanrack.runtime.modules.registry import OWN

from .adapter_bench import AdapterBench
from .card_bench import CardBench
from .drive_bench import DriveBench
from .image_bench import ImageBench, on_bench
from .pcl601_bench import pcl601_bench
from .pmc006_bench import pmc006_bench

Answer = Callable[[str], dict[str, Any]]
"""Returns the reply to a line with a request; raises RequestError if the request is illegal."""


def module_bench(record: ModuleRecord) -> Answer:
    """Return a fresh bench for a kind of module."""
    if Trait.LINE in record.traits:
        return AdapterBench(partial(on_bench, record)).answer
    words = record.words({})
    if is_stepper(words):
        return ImageBench(partial(on_bench, record), words).answer
    return CardBench(record).answer


def _drive_bench(model: Model) -> Answer:
    return DriveBench(model).answer


BENCHES: Mapping[str, Callable[[], Answer]] = {
    **{name: partial(module_bench, record) for name, record in OWN.items()},
    "pcl601": lambda: pcl601_bench().answer,
    "pmc006": lambda: pmc006_bench().answer,
    **{name: partial(_drive_bench, model) for name, model in MODELS.items()},
}
"""Functions that create a target's bench, by the target's name."""
