"""What a module of your own is made of: `from scanrack.modules import Image, ModuleRecord, ...`.

A rack file names the module's file:

    [modules]
    blinker = "blinker.py"

    [[slot]]
    number = 1
    module = "blinker"
    options = { half_ms = 20 }

The file has a `RECORD`, see `ModuleRecord`. `docs/own-module.md` shows a whole one. These names stay; all
others may move.
"""

from .io_images.amci3601 import RULES, Limits, Rule
from .io_images.amci3601.image_form import ImageForm
from .io_images.amci3601.words import WORDS_3601
from .io_images.image import Image
from .io_images.module_words import BitPlace, ModuleWords
from .io_images.number_formats import NumberFormat
from .runtime.loop.events import Event
from .runtime.loop.module import Follower, ForeseeingModule, Module
from .runtime.loop.options import Options
from .runtime.modules.amci3601.record import stepper
from .runtime.modules.record import ModuleRecord

__all__ = [
    "RULES",
    "WORDS_3601",
    "BitPlace",
    "Event",
    "Follower",
    "ForeseeingModule",
    "Image",
    "ImageForm",
    "Limits",
    "Module",
    "ModuleRecord",
    "ModuleWords",
    "NumberFormat",
    "Options",
    "Rule",
    "stepper",
]
