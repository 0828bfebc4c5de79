"""The actions of command word MSW, one function each [chapter 4; chapter 5, Command Word MSW].

The command layer calls a handler when its bit alone has risen and the module is not locked. The handler
either fires every broken rule or carries out the command.
"""

from __future__ import annotations

from collections.abc import Callable

from scanrack.io_images.amci3601 import CommandLsw, CommandMsw

from . import refusals
from .amci3601_capabilities import Feature
from .command_words import COMMAND_BITS, CommandWords
from .latches import HOME_INVALID, POSITION_INVALID, RESETTABLE
from .operation import Host
from .operations.axis_homing import HOMINGS
from .operations.blending import RUN_CW, BlendRun
from .operations.encoder_move import EncoderMove
from .operations.manual_move import MANUAL_BIT, ManualMove, OneShot
from .operations.profile_move import ProfileMove
from .operations.registration_move import RegistrationMove
from .refusals import ENCODER_MOVE, refuse_if_broken

Handler = Callable[[Host, int, CommandWords], None]

STORE_MIN_REG = CommandLsw.STORE_MIN_REG.value
FIND_HOME_CW = CommandMsw.FIND_HOME_CW.value


def absolute(host: Host, now_ns: int, command: CommandWords) -> None:
    """Move to the target position; with the encoder bit, move until the encoder reaches the target."""
    if refuse_if_broken(host, now_ns, command):
        return
    target = command.parameters.target
    assert target is not None
    if command.lsw & ENCODER_MOVE:
        _start_encoder_move(host, now_ns, command, target, target - host.axis.encoder)
    else:
        _start_profile_move(host, now_ns, command, "absolute", target)


def relative(host: Host, now_ns: int, command: CommandWords) -> None:
    """Move by the number of steps in the target words; with the encoder bit, by that number of counts."""
    if refuse_if_broken(host, now_ns, command):
        return
    distance = command.parameters.target
    assert distance is not None
    if command.lsw & ENCODER_MOVE:
        _start_encoder_move(host, now_ns, command, host.axis.encoder + distance, distance)
    else:
        _start_profile_move(host, now_ns, command, "relative", host.axis.position + distance)


def resume(host: Host, now_ns: int, command: CommandWords) -> None:
    """Continue the held move with the speed and rates in the words."""
    held_move = host.state.held
    if not refuse_if_broken(host, now_ns, command) and held_move is not None:
        _start_profile_move(host, now_ns, command, held_move.name, held_move.target)


def _start_profile_move(host: Host, now_ns: int, command: CommandWords, name: str, target: int) -> None:
    """Start a move to a position in steps, unless the axis can't make it; `name` is its name in events."""
    if host.refuse_if_unable(now_ns, Feature.MOVE, command, target - host.axis.position):
        return
    move = ProfileMove(host, now_ns, name, target, command.profile(host.state.start_sps))
    host.accept(move)
    move.start(now_ns)


def _start_encoder_move(host: Host, now_ns: int, command: CommandWords, target: int, counts: int) -> None:
    """Start a move to an encoder target that is a signed number of counts away."""
    if host.refuse_if_unable(now_ns, Feature.ENCODER_MOVE, command):
        return
    direction = 1 if counts >= 0 else -1
    move = EncoderMove(host, now_ns, target, direction, command.profile(host.state.start_sps))
    host.accept(move)
    move.start(now_ns)


def manual(host: Host, now_ns: int, command: CommandWords) -> None:
    """Move while the bit is set; with a target, end that number of steps after the registration input."""
    direction = 1 if command.msw & MANUAL_BIT[1] else -1
    move: ManualMove | OneShot
    if refuse_if_broken(host, now_ns, command):
        return
    if refusals.registers(host, command):
        if host.refuse_if_unable(now_ns, Feature.REGISTRATION, command):
            return
        move = RegistrationMove(host, now_ns, direction, command)
    elif host.refuse_if_unable(now_ns, Feature.MANUAL, command):
        return
    elif command.parameters.speed == 0:
        move = OneShot(host, now_ns, direction)
    else:
        move = ManualMove(host, now_ns, direction, command)
    host.accept(move)
    move.start(now_ns)


def find_home(host: Host, now_ns: int, command: CommandWords) -> None:
    """Home in the direction of the bit."""
    if refuse_if_broken(host, now_ns, command) or host.refuse_if_unable(now_ns, Feature.HOME, command):
        return
    direction = 1 if command.msw & FIND_HOME_CW else -1
    assert host.state.configuration is not None
    search = HOMINGS[host.axis.capabilities.homing_for(host.state.configuration.homing)]
    homing = search(host, now_ns, direction, command.profile(host.state.start_sps))
    host.state.latches.clear(HOME_INVALID)  # reading A-19
    host.accept(homing)
    homing.start(now_ns)


def run_blend(host: Host, now_ns: int, command: CommandWords) -> None:
    """Run the stored blend profile in the direction of the bit."""
    program = host.state.blend
    if refuse_if_broken(host, now_ns, command) or program is None:
        return
    operation = BlendRun(host, now_ns, 1 if command.msw & RUN_CW else -1, program)
    host.accept(operation)
    operation.start(now_ns)


def hold(host: Host, now_ns: int, command: CommandWords) -> None:
    """Hold the running move; the other words have no effect [chapter 4, Hold Move]."""
    if host.operation is None:
        host.fire(now_ns, "CMD-07")  # reading A-24
    else:
        host.operation.on_hold(now_ns)


def immediate_stop(host: Host, now_ns: int, command: CommandWords) -> None:
    """Cut a motion; without a motion no status bit changes [chapter 4, Immediate Stop]."""
    if host.cuttable:
        host.state.latches.fire(now_ns, "POS-02", alone=True)
        host.cut(now_ns)


def preset_position(host: Host, now_ns: int, command: CommandWords) -> None:
    """Set the position, and a diagnostic count, to the target; the position becomes valid."""
    if refuse_if_broken(host, now_ns, command):
        return
    value = command.parameters.target
    assert value is not None
    host.axis.preset_position(value)
    if host.state.configuration is not None and host.state.configuration.diagnostic_feedback:
        host.axis.preset_encoder(value)
    host.state.latches.clear(POSITION_INVALID)


def preset_encoder(host: Host, now_ns: int, command: CommandWords) -> None:
    """Set the encoder count to the target; the validity of the position does not change."""
    if refuse_if_broken(host, now_ns, command):
        return
    if not host.refuse_if_unable(now_ns, Feature.PRESET_ENCODER, command):
        value = command.parameters.target
        assert value is not None
        host.axis.preset_encoder(value)


def reset_errors(host: Host, now_ns: int, command: CommandWords) -> None:
    """Clear recoverable errors; a running motion continues."""
    if not refuse_if_broken(host, now_ns, command):
        host.state.latches.clear(RESETTABLE | host.profile.further_errors)
        host.axis.reset_errors()


def reserved(host: Host, now_ns: int, command: CommandWords) -> None:
    """Refuse the reserved bit (reading A-32)."""
    host.fire(now_ns, "LSW-03")


def obey_store_minimum(host: Host, now_ns: int, command: CommandWords, previous: CommandWords) -> None:
    """Store the minimum registration distance when LSW bit 10 rises; refuse it together with a command.

    A refusal also locks the module, so the other command is refused as well. Several command bits have
    precedence (reading A-93).
    """
    has_risen = command.lsw & STORE_MIN_REG and (previous.configures or not previous.lsw & STORE_MIN_REG)
    if not has_risen or not host.firmware.registration or host.state.locked:
        return
    if command.many_bits and command.msw & ~previous.msw & COMMAND_BITS:
        return
    if not refuse_if_broken(host, now_ns, command, refusals.STORE_MINIMUM):
        distance = command.parameters.target
        assert distance is not None
        host.state.store_minimum(distance)


COMMANDS: dict[int, Handler] = {
    CommandMsw.ABSOLUTE_MOVE.value: absolute,
    CommandMsw.RELATIVE_MOVE.value: relative,
    CommandMsw.HOLD_MOVE.value: hold,
    CommandMsw.RESUME_MOVE.value: resume,
    CommandMsw.IMMEDIATE_STOP.value: immediate_stop,
    CommandMsw.FIND_HOME_CW.value: find_home,
    CommandMsw.FIND_HOME_CCW.value: find_home,
    CommandMsw.MANUAL_CW.value: manual,
    CommandMsw.MANUAL_CCW.value: manual,
    CommandMsw.PRESET_POSITION.value: preset_position,
    CommandMsw.PRESET_ENCODER.value: preset_encoder,
    CommandMsw.RESET_ERRORS.value: reset_errors,
    CommandMsw.RUN_BLEND_CW.value: run_blend,
    CommandMsw.RUN_BLEND_CCW.value: run_blend,
    CommandMsw.RESERVED_14.value: reserved,
}
"""The handler of every command bit; bit 15 selects configuration mode."""
