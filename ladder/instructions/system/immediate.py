"""IOT, UID, UIE and HMIBC [1756-RM003N].

The rack's controller decides when images are exchanged (`micrologix`: at the ends of the scan,
`compactlogix`: every RPI). An IOT does not change that. A task interrupts others according to `Task.preempt`,
even between UID and UIE.
"""

from __future__ import annotations

from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.operands import Group, Resolved
from ...model.spec import Use, action, always, do_nothing


def _hmibc(machine: Interpreter, power: bool, group: Group, *_operands: Resolved) -> bool:
    button = Members(machine, group)
    button.set(EnableIn=power, EnableOut=power and bool(button["ButtonState"]))
    return bool(button["EnableOut"])


IOT = action("IOT", Use.IGNORED, run=do_nothing)
UID = action("UID", run=do_nothing)
UIE = action("UIE", run=do_nothing)
HMIBC = always("HMIBC", Use.HMI_BUTTON, Use.IGNORED, optional=1, run=_hmibc, decides=True, alone=True)
