"""What each bit of command word MSW does [chapter 4; chapter 5, Command Word MSW].

A handler is called when its bit, and no other, has risen and nothing locks the
module. It refuses the command by every rule that is broken, or carries it out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ....io_images.amci3601 import CommandLsw, CommandMsw
from . import refusals
from .axis_homing import HOMINGS
from .blending import RUN_CW, BlendRun
from .capabilities import Feature
from .command_words import COMMAND_BITS, CommandWords
from .encoder_move import EncoderMove
from .latches import COMMAND_ERROR, HOME_INVALID, POSITION_INVALID, RESETTABLE
from .manual_move import MANUAL_BIT, ManualMove, OneShot
from .profile_move import ProfileMove
from .refusals import ENCODER_MOVE
from .registration_move import RegistrationMove

if TYPE_CHECKING:
    from .command_layer import CommandLayer

Handler = Callable[["CommandLayer", int, CommandWords], None]

STORE_MIN_REG = CommandLsw.STORE_MIN_REG.value
FIND_HOME_CW = CommandMsw.FIND_HOME_CW.value


def absolute(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Move to the target position, or with the encoder bit until the encoder has reached it."""
    if layer.refused(now_ns, order):
        return
    target = order.parameters.target
    assert target is not None
    if order.lsw & ENCODER_MOVE:
        _start_encoder_move(layer, now_ns, order, target, target - layer.axis.encoder)
    else:
        _start_profile_move(layer, now_ns, order, "absolute", target)


def relative(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Move by the target's number of steps, or with the encoder bit of encoder counts."""
    if layer.refused(now_ns, order):
        return
    distance = order.parameters.target
    assert distance is not None
    if order.lsw & ENCODER_MOVE:
        _start_encoder_move(layer, now_ns, order, layer.axis.encoder + distance, distance)
    else:
        _start_profile_move(layer, now_ns, order, "relative", layer.axis.position + distance)


def resume(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Go on to the target of the held move, at the speed and rates of these words."""
    held = layer.held
    if not layer.refused(now_ns, order) and held is not None:
        _start_profile_move(layer, now_ns, order, held.name, held.target)


def _start_profile_move(
    layer: CommandLayer, now_ns: int, order: CommandWords, name: str, target: int
) -> None:
    if layer.unable(now_ns, Feature.MOVE, order, target - layer.axis.position):
        return
    move = ProfileMove(layer, now_ns, name, target, order.profile(layer.start_sps))
    layer.accept(move)
    move.start(now_ns)


def _start_encoder_move(layer: CommandLayer, now_ns: int, order: CommandWords, target: int, way: int) -> None:
    if layer.unable(now_ns, Feature.ENCODER_MOVE, order):
        return
    move = EncoderMove(layer, now_ns, target, 1 if way >= 0 else -1, order.profile(layer.start_sps))
    layer.accept(move)
    move.start(now_ns)


def manual(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Move as long as the bit is set; with a target, end so many steps after the registration input."""
    direction = 1 if order.msw & MANUAL_BIT[1] else -1
    move: ManualMove | OneShot
    if layer.refused(now_ns, order):
        return
    if refusals.registers(layer, order):
        if layer.unable(now_ns, Feature.REGISTRATION, order):
            return
        move = RegistrationMove(layer, now_ns, direction, order)
    elif layer.unable(now_ns, Feature.MANUAL, order):
        return
    elif order.parameters.speed == 0:
        move = OneShot(layer, now_ns, direction)
    else:
        move = ManualMove(layer, now_ns, direction, order)
    layer.accept(move)
    move.start(now_ns)


def find_home(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Search for home in the direction of the bit."""
    if layer.refused(now_ns, order) or layer.unable(now_ns, Feature.HOME, order):
        return
    direction = 1 if order.msw & FIND_HOME_CW else -1
    assert layer.configuration is not None
    search = HOMINGS[layer.axis.capabilities.homing_for(layer.configuration.homing)]
    homing = search(layer, now_ns, direction, order.profile(layer.start_sps))
    layer.latches.clear(HOME_INVALID)  # by the next accepted Find Home (reading A-19)
    layer.accept(homing)
    homing.start(now_ns)


def run_blend(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Run the stored blend profile in the direction of the bit."""
    program = layer.blend
    if layer.refused(now_ns, order) or program is None:
        return
    run = BlendRun(layer, now_ns, 1 if order.msw & RUN_CW else -1, program)
    layer.accept(run)
    run.start(now_ns)


def hold(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Hold the running move; the other words may hold anything [chapter 4, Hold Move]."""
    if layer.operation is None:
        layer.fire(now_ns, "CMD-07")  # nothing to hold (reading A-24)
    else:
        layer.operation.on_hold(now_ns)


def immediate_stop(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Cut the steps; without motion no status bit changes [chapter 4, Immediate Stop]."""
    if layer.busy:
        layer.latches.fire(now_ns, "POS-02", alone=True)
        layer.cut(now_ns)


def preset_position(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Let the position, and the diagnostic count if there is one, be the target; it becomes valid."""
    if layer.refused(now_ns, order):
        return
    value = order.parameters.target
    assert value is not None
    layer.axis.preset_position(value)
    if layer.configuration is not None and layer.configuration.diagnostic_feedback:
        layer.axis.preset_encoder(value)
    layer.latches.clear(POSITION_INVALID)


def preset_encoder(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Let the encoder count be the target; the validity of the position is not touched."""
    if layer.refused(now_ns, order):
        return
    if not layer.unable(now_ns, Feature.PRESET_ENCODER, order):
        value = order.parameters.target
        assert value is not None
        layer.axis.preset_encoder(value)


def reset_errors(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Clear the errors that can be recovered from; a running motion is not affected."""
    if not layer.refused(now_ns, order):
        layer.latches.clear(RESETTABLE)
        layer.axis.reset_errors()


def reserved(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """A bit that is no command (reading A-32)."""
    layer.fire(now_ns, "LSW-03", bits=COMMAND_ERROR)


def obey_store_minimum(layer: CommandLayer, now_ns: int, order: CommandWords, previous: CommandWords) -> None:
    """Store the minimum registration distance on the rise of LSW bit 10; beside a command it is refused.

    That error locks the command out, too. Several bits that come on are looked at first (reading A-93).
    """
    several = order.many_bits and order.msw & ~previous.msw & COMMAND_BITS
    risen = order.lsw & STORE_MIN_REG and (previous.configures or not previous.lsw & STORE_MIN_REG)
    if not risen or not layer.firmware.registration or layer.locked or several:
        return
    if not layer.refused(now_ns, order, refusals.STORE_MINIMUM):
        distance = order.parameters.target
        assert distance is not None
        layer.minimum_registration = distance
        layer.held = None  # Resume has to be the first command after a hold (reading A-83)


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
"""Every bit but the mode flag."""
