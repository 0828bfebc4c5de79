"""Command layers of a 3601 that follow other rules."""

from __future__ import annotations

from collections.abc import Iterable

from scanrack.runtime.modules.amci3601.altered import AlteredLayer
from scanrack.runtime.modules.amci3601.command_words import CommandWords
from scanrack.runtime.modules.amci3601.commands import COMMANDS
from scanrack.runtime.modules.amci3601.latches import (
    COMMAND_ERROR,
    HOLD_STATE,
    POSITION_INVALID,
    STOPPED,
    BrokenRule,
)
from scanrack.runtime.modules.amci3601.operation import Limits, Operation
from typing_extensions import override

from .departures import HOLD, RELATIVE, RESUME, STOP


class EdgeOfNothing(AlteredLayer):
    """Every change of the words starts the command of a bit that is still set."""

    @override
    def _obey_new_words(self, now_ns: int, command: CommandWords, previous: CommandWords) -> None:
        super()._obey_new_words(now_ns, command, CommandWords((0, *previous.words[1:])))


class IgnoresNewWords(AlteredLayer):
    """A manual move ignores new words under the same command bit."""

    @override
    def _obey_new_words(self, now_ns: int, command: CommandWords, previous: CommandWords) -> None:
        if self.under_way not in ("manual", "registration") or command.msw != previous.msw:
            super()._obey_new_words(now_ns, command, previous)


class NoLock(AlteredLayer):
    """Commands are carried out even during a command error."""

    @override
    def _command(self, now_ns: int, command: CommandWords, edges: int) -> None:
        if self.state.locked and not command.many_bits:
            COMMANDS[command.msw](self, now_ns, command)
        else:
            super()._command(now_ns, command, edges)


class ResumableForEver(AlteredLayer):
    """A held move can still be resumed after other commands and errors."""

    @override
    def _forfeit(self) -> None: ...


class SilentIdleHold(AlteredLayer):
    """Hold does nothing while the axis is at rest."""

    @override
    def _command(self, now_ns: int, command: CommandWords, edges: int) -> None:
        if command.msw != HOLD or self.operation is not None:
            super()._command(now_ns, command, edges)


class HoldCuts(AlteredLayer):
    """Hold ends an absolute or relative move without a deceleration ramp."""

    @override
    def _command(self, now_ns: int, command: CommandWords, edges: int) -> None:
        super()._command(now_ns, command, edges)
        if command.msw == HOLD and self.under_way in ("absolute", "relative"):
            self.axis.cut(now_ns)


class StopHolds(AlteredLayer):
    """Immediate Stop ends a motion as Hold does."""

    @override
    def _command(self, now_ns: int, command: CommandWords, edges: int) -> None:
        if command.msw == STOP and self.operation is not None and not self.state.locked:
            self.operation.on_hold(now_ns)
        else:
            super()._command(now_ns, command, edges)


class ResumesAnew(AlteredLayer):
    """Resume after a hold starts a relative move with its own target words."""

    @override
    def _command(self, now_ns: int, command: CommandWords, edges: int) -> None:
        if command.msw == RESUME and self.state.held is not None and not self.state.locked:
            COMMANDS[RELATIVE](self, now_ns, CommandWords((RELATIVE, *command.words[1:])))
        else:
            super()._command(now_ns, command, edges)


class HoldCutsManual(AlteredLayer):
    """Hold stops a manual move without a deceleration ramp."""

    @override
    def _command(self, now_ns: int, command: CommandWords, edges: int) -> None:
        super()._command(now_ns, command, edges)
        if command.msw == HOLD and self.under_way == "manual":
            self.state.latches.bits |= POSITION_INVALID
            self.cut(now_ns)


class StoppedAtRest(AlteredLayer):
    """Immediate Stop sets Stopped even if nothing moves."""

    @override
    def _command(self, now_ns: int, command: CommandWords, edges: int) -> None:
        super()._command(now_ns, command, edges)
        if command.msw == STOP and self.operation is None and not self.state.locked:
            self.state.latches.complete(STOPPED)


class StrictLsw(AlteredLayer):
    """Hold, Resume and Immediate Stop require an LSW of zero."""

    @override
    def _command(self, now_ns: int, command: CommandWords, edges: int) -> None:
        if command.msw in (HOLD, RESUME, STOP) and command.lsw and not self.state.locked:
            self.fire(now_ns, "IOM-20")
        else:
            super()._command(now_ns, command, edges)


class ManualThroughSeveral(AlteredLayer):
    """A manual move continues if several command bits are set."""

    @override
    def _refuse_several(self, now_ns: int, command: CommandWords, edges: int) -> None:
        self.fire_all(now_ns, [BrokenRule("CMD-02")])


class OneFaultAtATime(AlteredLayer):
    """If a command has several faults, only the first one sets bits."""

    @override
    def fire_all(self, now_ns: int, faults: Iterable[BrokenRule]) -> None:
        super().fire_all(now_ns, list(faults)[:1])


class ErrorWithoutConfiguration(AlteredLayer):
    """A command without a configuration is a command error."""

    @override
    def _obey(self, now_ns: int, words: tuple[int, ...]) -> None:
        previous_msw = self.state.command.msw
        super()._obey(now_ns, words)
        command = self.state.command
        if self.state.configuration is None and not command.configures and command.msw & ~previous_msw:
            self.state.latches.bits |= COMMAND_ERROR


class EdgeAfterConfiguration(AlteredLayer):
    """A command bit that is set in the configuration word starts its command when the mode ends."""

    @override
    def _obey(self, now_ns: int, words: tuple[int, ...]) -> None:
        if self.state.in_configuration_mode and words[0] >= 0:
            # count only MODE_CONFIG as already set, so that every other bit is an edge
            self.state.command = CommandWords((-32_768, 0, *self.state.command.words[2:]))
        super()._obey(now_ns, words)


class StoppedAtEveryEnd(AlteredLayer):
    """Every end of a motion sets Stopped."""

    @override
    def finish(self, now_ns: int, completion: int, outcome: str) -> None:
        super().finish(now_ns, completion, outcome)
        self.state.latches.bits |= STOPPED


class StoppedAfterOneShot(AlteredLayer):
    """Stopped is set when the bit of a one-shot command is released."""

    @override
    def finish(self, now_ns: int, completion: int, outcome: str) -> None:
        is_one_shot = self.operation is not None and self.operation.name == "one-shot manual"
        super().finish(now_ns, STOPPED if is_one_shot else completion, outcome)


class ManualInvalidates(AlteredLayer):
    """The position is invalid after a manual move."""

    @override
    def finish(self, now_ns: int, completion: int, outcome: str) -> None:
        is_manual = self.operation is not None and self.operation.name == "manual"
        super().finish(now_ns, completion, outcome)
        if is_manual:
            self.state.latches.bits |= POSITION_INVALID


class NoDistanceNoEnd(AlteredLayer):
    """A move of distance zero does not set Move Complete."""

    @override
    def finish(self, now_ns: int, completion: int, outcome: str) -> None:
        has_no_distance = self.operation is not None and self.operation.started_at == self.axis.position
        super().finish(now_ns, 0 if has_no_distance else completion, outcome)


class BlendOnce(AlteredLayer):
    """A blend profile is lost once it has run."""

    @override
    def finish(self, now_ns: int, completion: int, outcome: str) -> None:
        is_blend = self.operation is not None and self.operation.name == "blend"
        super().finish(now_ns, completion, outcome)
        if is_blend:
            self.state.blend = None


class ResumeEndsHold(AlteredLayer):
    """A refused Resume clears Hold State."""

    @override
    def _command(self, now_ns: int, command: CommandWords, edges: int) -> None:
        super()._command(now_ns, command, edges)
        if command.msw == RESUME and self.state.locked:
            self.state.latches.clear(HOLD_STATE)


class CutByChange(AlteredLayer):
    """An invalid change during a manual move stops it without a ramp."""

    @override
    def _obey_new_words(self, now_ns: int, command: CommandWords, previous: CommandWords) -> None:
        was_locked = self.state.locked
        super()._obey_new_words(now_ns, command, previous)
        is_refused = self.state.locked and not was_locked
        if is_refused and self.under_way == "manual" and command.msw == previous.msw:
            self.cut(now_ns)


class ErrorAtZeroWords(AlteredLayer):
    """Eight zero words during a manual move are a command error."""

    @override
    def _obey_new_words(self, now_ns: int, command: CommandWords, previous: CommandWords) -> None:
        if self.under_way == "manual" and not any(command.words):
            self.state.latches.bits |= COMMAND_ERROR
        super()._obey_new_words(now_ns, command, previous)


class OneLook(AlteredLayer):
    """A configuration is checked only on entry to configuration mode."""

    @override
    def _obey(self, now_ns: int, words: tuple[int, ...]) -> None:
        if not (self.state.in_configuration_mode and words[0] < 0):
            super()._obey(now_ns, words)


class StoppedWithoutHome(AlteredLayer):
    """A home search that was stopped by end limits sets Stopped."""

    @override
    def abort_homing(self, now_ns: int, rule_id: str) -> None:
        super().abort_homing(now_ns, rule_id)
        self.state.latches.bits |= STOPPED


class LimitAhead(AlteredLayer):
    """Only the end limit in the direction of motion stops a move."""

    @override
    def accept(self, operation: Operation) -> None:
        if operation.limits is Limits.EITHER:
            operation.limits = Limits.SAME_DIRECTION  # type: ignore[misc]
        super().accept(operation)


class IgnoresExternal(AlteredLayer):
    """The external input does not stop a motion."""

    @override
    def accept(self, operation: Operation) -> None:
        operation.on_external = _do_nothing  # type: ignore[assignment, method-assign]
        super().accept(operation)


def _do_nothing(_now_ns: int) -> None: ...
