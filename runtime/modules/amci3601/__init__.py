"""The simulated AMCI 3601: a command layer with the manual's rules, and an axis that makes steps.

`Amci3601` is the module. `CommandLayer` has the manual's rules and works over any `Axis`;
`StepGenerator` is the simulated one.
"""

from ...loop.module_fault import ModuleFault
from .amci3601_capabilities import AxisHoming, AxisRequest, Capabilities, Feature, Refusal
from .amci3601_options import Amci3601Options
from .axis_protocol import Axis
from .command_layer import CommandLayer
from .indicators import Indicators, Light
from .module import Amci3601
from .state import ModuleState
from .step_generator import StepGenerator

__all__ = [
    "Amci3601",
    "Amci3601Options",
    "Axis",
    "AxisHoming",
    "AxisRequest",
    "Capabilities",
    "CommandLayer",
    "Feature",
    "Indicators",
    "Light",
    "ModuleFault",
    "ModuleState",
    "Refusal",
    "StepGenerator",
]
