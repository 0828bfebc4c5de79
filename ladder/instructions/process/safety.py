"""Safety instructions: dual channel input stop, configurable redundant output.

The manual, 1756-RM095, was not available. Operands and members come from exports; codes, and the conditions
that reset a fault, are from memory.

    DCS     channels  ____|‾‾‾‾‾‾‾‾‾‾‾‾‾|_____     active according to the input type
            Reset     ________|‾|_____________     restart MANUAL; AUTOMATIC needs none
            O1        ________|‾‾‾‾‾‾‾‾‾|_____
    CROUT   Actuate   ____|‾‾‾‾‾‾‾‾‾|_________
            O1, O2    ____|‾‾‾‾‾‾‾‾‾|_________
            feedback  _______|‾‾‾‾‾‾‾‾‾|______     within the reaction time; NEGATIVE is inverted

A fault sets FP and FaultCode and turns the outputs off until Reset rises after the cause is gone. If the
channels differed, both must be safe first. A false rung turns all outputs off and clears the fault.

| FaultCode of DCS | channels |
|---|---|
| 16#20 | InputStatus turned off |
| 16#4000, 16#4001 | differed for the discrepancy time with channel A active, channel B active |
| 16#4002, 16#4003 | channel A, channel B, went to safe and back while the other channel stayed active |

| FaultCode of CROUT | feedback 1 and 2, 1, 2 |
|---|---|
| 16#20, 16#21 | InputStatus, OutputStatus, turned off |
| 16#5000 to 16#5002 | turned off without a change of the outputs |
| 16#5003 to 16#5005 | turned on without a change of the outputs |
| 16#5006 to 16#5008 | not on within the reaction time |
| 16#5009 to 16#500B | not off within the reaction time |

Without a fault, DiagnosticCode is the missing condition: 5 Reset is off, 16#20 and 16#21 a status is off,
16#5000 Actuate is off.
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
    """Return the index of a word in its list, or the value of a numeric operand."""
    if isinstance(operand, str):
        return next((number for number, word in enumerate(words) if plain(word) == operand), 0)
    return machine.integer(operand)


def _truths(machine: Interpreter, operands: tuple[Resolved, ...]) -> list[bool]:
    return [machine.condition(operand) for operand in operands]


def _rises(block: Members, name: str, value: bool) -> bool:
    """Store a bit; return whether it has risen since the last scan."""
    before = block[f"~{name}"]
    block.set(**{f"~{name}": value})
    return value and not before


def _fault(block: Members, code: int) -> None:
    block.set(FP=True, FaultCode=code, DiagnosticCode=0)


# --- DCS


def _dcs(machine: Interpreter, power: bool, group: Group, *operands: Resolved) -> None:
    """Run DCS: show the operands, reset a fault, monitor status and channels, then set O1.

    `~tested` is true once both channels were safe, or after an automatic cold start. `~free` lets O1 turn
    on without a reset. A reset that clears a fault does not also turn O1 on.
    """
    block = Members(machine, group)
    function, kind, limit, restart, cold = operands[:5]
    channel_a, channel_b, status, reset = _truths(machine, operands[5:])
    complementary = bool(_number(machine, kind, INPUT_TYPES))
    automatic, cold_automatic = bool(_number(machine, restart, STARTS)), bool(_number(machine, cold, STARTS))
    limit_ms = machine.integer(limit)
    block.set(EnableIn=power, EnableOut=power, ChannelA=channel_a, ChannelB=channel_b)
    block.set(InputStatus=status, Reset=reset)
    block.set(RestartType=automatic, ColdStartType=cold_automatic, InputType=complementary)
    block.set(DiscrepancyTime=limit_ms, SafetyFunction=_number(machine, function, FUNCTIONS))
    if not power:
        _forget(machine, group)
        return
    rises = _rises(block, "reset", reset)
    channels = channel_a, channel_b != complementary
    clears = rises and status and _is_clearable(block)
    if clears:
        block.set(FP=False, FaultCode=0, **{"~apart": False, "~left": 0})
    _monitor_status(block, status, cold_automatic)
    if status:
        _monitor_channels(machine, block, channels, limit_ms)
    if not any(channels):
        block.set(**{"~tested": True, "~free": automatic})
    restarts = bool(block["~free"]) or (rises and not clears)
    _set_dcs_output(block, active=all(channels), status=status, restarts=restarts, reset=reset)


def _is_clearable(block: Members) -> bool:
    """Return whether the channels allow a fault to be cleared."""
    return bool(block["FP"] and (block["FaultCode"] == INPUT_OFF or block["~tested"]))


def _set_dcs_output(block: Members, *, active: bool, status: bool, restarts: bool, reset: bool) -> None:
    """Set O1, and DiagnosticCode to the missing condition."""
    ready = active and status and not block["FP"] and bool(block["~tested"])
    on = ready and bool(block["O1"] or restarts)
    code = 0 if status or block["FP"] else INPUT_OFF
    if ready and not on and reset:
        code = RESET_HELD
    block.set(O1=on, DiagnosticCode=code)


def _monitor_status(block: Members, status: bool, cold_automatic: bool) -> None:
    """Record when the inputs become valid; fault if they become invalid again."""
    if status and not block["~valid"] and not block["FP"]:
        block.set(**{"~valid": True, "~tested": cold_automatic, "~free": cold_automatic})
        block.set(**{"~both": False, "~apart": False, "~left": 0})
    elif not status and block["~valid"]:
        block.set(**{"~valid": False})
        if not block["FP"]:
            _fault(block, INPUT_OFF)


def _monitor_channels(
    machine: Interpreter, block: Members, channels: tuple[bool, bool], limit_ms: int
) -> None:
    """Fault if the channels differ too long, or if one channel cycles while the other stays active."""
    channel_a, channel_b = channels
    if channel_a == channel_b:
        if channel_a and block["~left"] and not block["FP"]:
            _fault_until_safe(block, LEFT + int(block["~left"]) - 1)
        block.set(**{"~apart": False, "~both": channel_a, "~left": 0})
        return
    if block["~both"]:
        block.set(**{"~both": False, "~left": 1 + channel_a})
    if not block["~apart"]:
        block.set(**{"~apart": True, "~since_ns": machine.now_ns})
    if not block["FP"] and _lasts(machine, block, limit_ms):
        _fault_until_safe(block, DIFFERED + channel_b)


def _lasts(machine: Interpreter, block: Members, limit_ms: int) -> bool:
    return machine.now_ns - int(block["~since_ns"]) >= limit_ms * _NS_PER_MS


def _fault_until_safe(block: Members, code: int) -> None:
    """Fault, and require both channels to be safe before a reset."""
    _fault(block, code)
    block.set(**{"~tested": False})


# --- CROUT


def _crout(machine: Interpreter, power: bool, group: Group, *operands: Resolved) -> None:
    """Run CROUT: reset a fault, monitor statuses and feedbacks, then set the outputs.

    `~held` is true after a reset with Actuate on. The outputs then stay off until Actuate turns off.
    """
    block = Members(machine, group)
    positive, limit_ms = bool(_number(machine, operands[0], FEEDBACKS)), machine.integer(operands[1])
    actuate, first, second, inputs, outputs, reset = _truths(machine, operands[2:])
    block.set(EnableIn=power, EnableOut=power, Actuate=actuate, Reset=reset)
    block.set(Feedback1=first, Feedback2=second, InputStatus=inputs, OutputStatus=outputs)
    block.set(FeedbackType=positive, FeedbackReactionTime=limit_ms)
    if not power:
        _forget(machine, group)
        return
    rises = _rises(block, "reset", reset)
    off_code = _status_off(inputs, outputs)
    expected = bool(block["O1"]) == positive
    is_reset_allowed = off_code == 0 and first == second == expected
    if rises and block["FP"] and is_reset_allowed:
        block.set(FP=False, FaultCode=0, **{"~held": actuate})
    if not block["FP"]:
        _monitor(machine, block, (first, second), expected, off_code=off_code, limit_ms=limit_ms)
    must_restart = actuate and bool(block["~held"])
    _set_outputs(machine, block, actuate and not (off_code or block["FP"] or must_restart))
    code = 0
    if not block["FP"]:
        code = off_code or (ACTUATE_HELD if must_restart else 0)
    block.set(DiagnosticCode=code, **{"~valid": not off_code, "~held": must_restart})


def _status_off(inputs: bool, outputs: bool) -> int:
    """Return the code for the status that is off; 0 if both are on."""
    if not inputs:
        return INPUT_OFF
    return 0 if outputs else OUTPUT_OFF


def _set_outputs(machine: Interpreter, block: Members, active: bool) -> None:
    """Switch both outputs if they must change, and start the reaction time."""
    if active != block["O1"]:
        block.set(O1=active, O2=active, **{"~settled": False, "~moved": True, "~since_ns": machine.now_ns})


def _monitor(
    machine: Interpreter,
    block: Members,
    feedback: tuple[bool, bool],
    expected: bool,
    *,
    off_code: int,
    limit_ms: int,
) -> None:
    """Fault if a status turns off, or if a feedback does not follow the outputs in time.

    `~settled` is true once the feedback has matched since the last change. `~moved` is true once the
    outputs have changed.
    """
    if block["~valid"] and off_code:
        _fault(block, off_code)
        return
    if not block["~powered"]:
        block.set(**{"~powered": True, "~since_ns": machine.now_ns})
    if feedback == (expected, expected):
        block.set(**{"~settled": True})
        return
    first, second = feedback
    reason = _WRONG_FEEDBACK[first == expected, second == expected]
    late = _lasts(machine, block, limit_ms)
    if block["~settled"] or (late and not block["~moved"]):
        _fault(block, (TURNED_OFF if expected else TURNED_ON) + reason)
    elif late:
        _fault(block, (NOT_ON if expected else NOT_OFF) + reason)


_WRONG_FEEDBACK = {(False, False): 0, (False, True): 1, (True, False): 2}
"""Offset of the fault code, by whether feedback 1 and 2 match the outputs."""


# --- the rows


def _forget(machine: Interpreter, group: Group, *_operands: Resolved) -> None:
    """Turn the outputs off and clear the state, as prescan and a false rung do."""
    members = Members(machine, group)
    kind = group.type
    hidden = {f"~{member.name}": 0 for member in getattr(kind, "hidden", ())}
    members.set(O1=False, FP=False, FaultCode=0, DiagnosticCode=0, **hidden)
    if kind == SAFETY["CROUT"]:
        members.set(O2=False)


def _check_time(name: str, time_index: int, most_ms: int) -> Callable[..., None]:
    """Return a check of the block's type and of a constant time, which must be 5 to `most_ms` ms."""

    def check(block: Group, *operands: Resolved) -> None:
        require_type(block, SAFETY[name])
        limit = operands[time_index]
        if isinstance(limit, Constant) and not 5 <= limit.value <= most_ms:
            raise OperandError(f"time {limit.value} ms is out of range", f"must be 5 to {most_ms} ms")

    return check


DCS = always(
    "DCS",
    *(Use.BLOCK, Use.KEYWORD, Use.KEYWORD, Use.INTEGER, Use.KEYWORD, Use.KEYWORD),
    *[Use.SWITCH] * 4,
    run=_dcs,
    prescan=_forget,
    check=_check_time("DCS", 2, 3000),
)
CROUT = always(
    "CROUT",
    *(Use.BLOCK, Use.KEYWORD, Use.INTEGER),
    *[Use.SWITCH] * 6,
    run=_crout,
    prescan=_forget,
    check=_check_time("CROUT", 1, 1000),
)
