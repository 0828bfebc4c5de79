"""Safety instructions: dual channel input stop, configurable redundant output.

Their manual, 1756-RM095, was not at hand: operands and members are those of exports; codes, and what resets
a fault, are from memory.


    DCS     channels  ____|‾‾‾‾‾‾‾‾‾‾‾‾‾|_____     active as the input type says
            Reset     ________|‾|_____________     restart MANUAL; AUTOMATIC needs none
            O1        ________|‾‾‾‾‾‾‾‾‾|_____
    CROUT   Actuate   ____|‾‾‾‾‾‾‾‾‾|_________
            O1, O2    ____|‾‾‾‾‾‾‾‾‾|_________
            feedback  _______|‾‾‾‾‾‾‾‾‾|______     within the reaction time; NEGATIVE the other way round

A fault sets FP and FaultCode and turns the outputs off until Reset rises with its cause gone: channels that
differed have both to be safe in between. On a false rung all outputs are off and the fault is forgotten.

| FaultCode of DCS | channels |
|---|---|
| 16#20 | InputStatus turned off |
| 16#4000, 16#4001 | differed for the discrepancy time, channel A active, channel B active |
| 16#4002, 16#4003 | channel A, B, went to safe and back while the other one stayed active |

| FaultCode of CROUT | feedback 1 and 2, 1, 2 |
|---|---|
| 16#20, 16#21 | InputStatus, OutputStatus, turned off |
| 16#5000 to 16#5002 | turned off without a change of the outputs |
| 16#5003 to 16#5005 | turned on without a change of the outputs |
| 16#5006 to 16#5008 | not on within the reaction time |
| 16#5009 to 16#500B | not off within the reaction time |

DiagnosticCode is the awaited condition without a fault: 5 Reset off, 16#20 and 16#21 the statuses, 16#5000
Actuate off.
"""

from __future__ import annotations

from collections.abc import Callable

from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.operand_checks import OperandError, require_type
from ...model.operands import Constant, Group, Resolved
from ...model.predefined.safety_types import FEEDBACKS, FUNCTIONS, INPUT_TYPES, SAFETY, STARTS
from ...model.predefined.words import plain
from ...model.spec import Use, always

_NS_PER_MS = 1_000_000
INPUT_OFF, OUTPUT_OFF, RESET_HELD, ACTUATE_HELD = 0x20, 0x21, 5, 0x5000
DIFFERED, LEFT = 0x4000, 0x4002
TURNED_OFF, TURNED_ON, NOT_ON, NOT_OFF = 0x5000, 0x5003, 0x5006, 0x5009


def _number(machine: Interpreter, operand: Resolved | str, words: tuple[str, ...]) -> int:
    """Return the index of a word in its list, or the number given instead."""
    if isinstance(operand, str):
        return next((number for number, word in enumerate(words) if plain(word) == operand), 0)
    return machine.integer(operand)


def _truths(machine: Interpreter, operands: tuple[Resolved, ...]) -> list[bool]:
    return [machine.condition(each) for each in operands]


def _rises(block: Members, name: str, value: bool) -> bool:
    """Remember a bit; return whether it has risen since the last scan."""
    before = block[f"~{name}"]
    block.set(**{f"~{name}": value})
    return value and not before


def _fault(block: Members, code: int) -> None:
    block.set(FP=True, FaultCode=code, DiagnosticCode=0)


# --- DCS


def _dcs(machine: Interpreter, power: bool, group: Group, *operands: Resolved) -> None:
    block = Members(machine, group)
    function, kind, limit, restart, cold = operands[:5]
    first, second, status, reset = _truths(machine, operands[5:])
    complementary = bool(_number(machine, kind, INPUT_TYPES))
    automatic, at_once = (bool(_number(machine, each, STARTS)) for each in (restart, cold))
    wait = machine.integer(limit)
    block.set(EnableIn=power, EnableOut=power, ChannelA=first, ChannelB=second)
    block.set(InputStatus=status, Reset=reset)
    block.set(RestartType=automatic, ColdStartType=at_once, InputType=complementary, DiscrepancyTime=wait)
    block.set(SafetyFunction=_number(machine, function, FUNCTIONS))
    if not power:
        _forget(machine, group)
        return
    asked = _rises(block, "reset", reset)
    channels = first, second != complementary
    if asked and block["FP"] and status and (block["FaultCode"] == INPUT_OFF or block["~tested"]):
        asked = False
        block.set(FP=False, FaultCode=0, **{"~apart": False, "~left": 0})
    _status(block, status, at_once)
    if status:
        _channels(machine, block, channels, wait)
    if not any(channels):
        block.set(**{"~tested": True, "~free": automatic})
    ready = all(channels) and status and not block["FP"] and bool(block["~tested"])
    on = ready and bool(block["O1"] or block["~free"] or asked)
    held = ready and not on and reset
    block.set(O1=on, DiagnosticCode=RESET_HELD if held else 0 if status or block["FP"] else INPUT_OFF)


def _status(block: Members, status: bool, at_once: bool) -> None:
    """Note that the inputs become valid, or fault."""
    if status and not block["~valid"] and not block["FP"]:
        block.set(**{"~valid": True, "~tested": at_once, "~free": at_once})
        block.set(**{"~both": False, "~apart": False, "~left": 0})
    elif not status and block["~valid"]:
        block.set(**{"~valid": False})
        if not block["FP"]:
            _fault(block, INPUT_OFF)


def _channels(machine: Interpreter, block: Members, channels: tuple[bool, bool], wait: int) -> None:
    """Fault on channels that differ too long, or if one cycles while the other stays active."""
    if channels[0] == channels[1]:
        if all(channels) and block["~left"] and not block["FP"]:
            _differ(block, LEFT + int(block["~left"]) - 1)
        block.set(**{"~apart": False, "~both": channels[0], "~left": 0})
        return
    if block["~both"]:
        block.set(**{"~both": False, "~left": 2 if channels[0] else 1})
    if not block["~apart"]:
        block.set(**{"~apart": True, "~since_ns": machine.now_ns})
    if not block["FP"] and machine.now_ns - int(block["~since_ns"]) >= wait * _NS_PER_MS:
        _differ(block, DIFFERED if channels[0] else DIFFERED + 1)


def _differ(block: Members, code: int) -> None:
    _fault(block, code)
    block.set(**{"~tested": False})


# --- CROUT


def _crout(machine: Interpreter, power: bool, group: Group, *operands: Resolved) -> None:
    block = Members(machine, group)
    positive, limit = bool(_number(machine, operands[0], FEEDBACKS)), machine.integer(operands[1])
    actuate, first, second, inputs, outputs, reset = _truths(machine, operands[2:])
    block.set(EnableIn=power, EnableOut=power, Actuate=actuate, Reset=reset)
    block.set(Feedback1=first, Feedback2=second, InputStatus=inputs, OutputStatus=outputs)
    block.set(FeedbackType=positive, FeedbackReactionTime=limit)
    if not power:
        _forget(machine, group)
        return
    asked = _rises(block, "reset", reset)
    valid = inputs and outputs
    wanted = bool(block["O1"]) == positive
    matched = first == wanted and second == wanted
    if asked and block["FP"] and valid and matched:
        block.set(FP=False, FaultCode=0, **{"~held": actuate})
    if not block["FP"]:
        if block["~valid"] and not valid:
            _fault(block, OUTPUT_OFF if inputs else INPUT_OFF)
        else:
            _feedback(machine, block, (first, second), wanted, limit)
    on = actuate and valid and not block["FP"] and not block["~held"]
    if not actuate:
        block.set(**{"~held": False})
    if on != block["O1"]:
        block.set(O1=on, O2=on, **{"~settled": False, "~moved": True, "~since_ns": machine.now_ns})
    waits = 0 if inputs and outputs else OUTPUT_OFF if inputs else INPUT_OFF
    waits = waits or (ACTUATE_HELD if block["~held"] else 0)
    block.set(DiagnosticCode=0 if block["FP"] else waits, **{"~valid": valid})


def _feedback(
    machine: Interpreter, block: Members, feedback: tuple[bool, bool], wanted: bool, limit: int
) -> None:
    """Fault on a feedback that follows the outputs too late or changes without them."""
    if not block["~powered"]:
        block.set(**{"~powered": True, "~since_ns": machine.now_ns})
    if feedback == (wanted, wanted):
        block.set(**{"~settled": True})
        return
    wrong = 0 if wanted not in feedback else 1 if feedback[0] != wanted else 2
    late = machine.now_ns - int(block["~since_ns"]) >= limit * _NS_PER_MS
    if block["~settled"] or (late and not block["~moved"]):
        _fault(block, (TURNED_OFF if wanted else TURNED_ON) + wrong)
    elif late:
        _fault(block, (NOT_ON if wanted else NOT_OFF) + wrong)


# --- the rows


def _forget(machine: Interpreter, group: Group, *_operands: Resolved) -> None:
    """Turn the outputs off and clear the state, as prescan and a false rung do."""
    members = Members(machine, group)
    kind = group.type
    hidden = {f"~{each.name}": 0 for each in getattr(kind, "hidden", ())}
    members.set(O1=False, FP=False, FaultCode=0, DiagnosticCode=0, **hidden)
    if kind == SAFETY["CROUT"]:
        members.set(O2=False)


def _checks(name: str, time: int, most: int) -> Callable[..., None]:
    def check(block: Group, *operands: Resolved) -> None:
        require_type(block, SAFETY[name])
        limit = operands[time]
        if isinstance(limit, Constant) and not 5 <= limit.value <= most:
            raise OperandError(f"{limit.value} ms is not 5 to {most} ms", "write a time within this range")

    return check


DCS = always(
    "DCS",
    *(Use.BLOCK, Use.KEYWORD, Use.KEYWORD, Use.INTEGER, Use.KEYWORD, Use.KEYWORD),
    *[Use.SWITCH] * 4,
    run=_dcs,
    prescan=_forget,
    check=_checks("DCS", 2, 3000),
)
CROUT = always(
    "CROUT",
    *(Use.BLOCK, Use.KEYWORD, Use.INTEGER),
    *[Use.SWITCH] * 6,
    run=_crout,
    prescan=_forget,
    check=_checks("CROUT", 1, 1000),
)
