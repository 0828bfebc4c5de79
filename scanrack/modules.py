"""The names for writing your own module: `from scanrack.modules import Image, ModuleRecord, ...`.

A rack file names the module's file:

    [modules]
    blinker = "blinker.py"

    [[slot]]
    number = 1
    module = "blinker"
    options = { half_ms = 20 }

The file defines `RECORD`, see `ModuleRecord`. `docs/own-module.md` shows a complete module. The names in this
module are stable; other names may move.
"""

from scanrack.io_images.amci3601 import RULES, Limits, Rule
from scanrack.io_images.amci3601.image_form import ImageForm
from scanrack.io_images.amci3601.words import WORDS_3601
from scanrack.io_images.image import Image
from scanrack.io_images.module_words import BitPlace, ModuleWords
from scanrack.io_images.number_formats import NumberFormat
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.module import Follower, ForeseeingModule, Module
from scanrack.runtime.loop.module_options import Options
from scanrack.runtime.modules.amci3601.record import stepper
from scanrack.runtime.modules.record import ModuleRecord

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
