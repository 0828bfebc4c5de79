"""The discrete inputs, sampled at every tick; some of them stop any operation [chapter 6]."""

from __future__ import annotations

from scanrack.io_images.amci3601 import ALL_INPUTS, InputBit

from .operation import CCW_LIMIT, CW_LIMIT, EITHER_LIMIT, Host, Limits, limit_in

CAPTURE = InputBit.CAPTURE.value
ESTOP = InputBit.ESTOP.value


class InputWatch:
    """Samples the inputs into the state, and obeys emergency stop, end limits and the external input."""

    def __init__(self, host: Host) -> None:
        self.host = host
        self.state = host.state

    # -- sampling -----------------------------------------------------------------------------

    def sample(self, levels: int) -> None:
        """Sample electrical levels, a mask of `InputBit`; capture on a change to active."""
        state, configuration = self.state, self.state.configuration
        active_before, state.active = state.active, self._active(levels)
        state.reported_inputs = state.active
        if configuration is not None and self.host.options.report_unused_inputs:
            state.reported_inputs |= levels & ALL_INPUTS & ~configuration.inputs_used
        # an input that is already active when it is configured makes no edge (reading A-69)
        state.risen = 0 if state.in_configuration_mode else state.active & ~active_before
        if state.risen & CAPTURE:
            self._capture()

    def _active(self, levels: int) -> int:
        """Return the mask of active inputs, without unused ones (reading A-13)."""
        configuration = self.state.configuration
        return 0 if configuration is None else configuration.active_inputs(levels)

    def _capture(self) -> None:
        """Store the encoder count, or the position if there is no encoder [chapter 3, MSW bit 0]."""
        axis, configuration = self.host.axis, self.state.configuration
        has_encoder = configuration is not None and configuration.quadrature_encoder
        self.state.captured = axis.encoder if has_encoder else axis.position

    # -- inputs that stop motion ---------------------------------------------------------------

    def obey(self, now_ns: int) -> None:
        """Stop motion as the active inputs require."""
        if self.state.active & ESTOP:
            self._emergency_stop(now_ns)
        elif self.state.active & EITHER_LIMIT:
            self._end_limit(now_ns)
        operation = self.host.operation
        if self.state.external_active and operation is not None and not operation.over:
            operation.on_external(now_ns)

    def _emergency_stop(self, now_ns: int) -> None:
        """Obey an active emergency stop input [chapter 6, Emergency Stop Input; reading A-15]."""
        if self.host.cuttable:
            self.state.latches.fire(now_ns, "INP-01")
            self.state.latches.fire(now_ns, "POS-03", alone=True)
            self.host.cut(now_ns)
        elif self.state.risen & ESTOP:
            self.state.latches.fire(now_ns, "INP-01")
            self.state.held = None

    def _end_limit(self, now_ns: int) -> None:
        """Obey an active end limit [chapter 4, general note 4]."""
        if self.state.risen & EITHER_LIMIT:
            self.state.held = None
        operation = self.host.operation
        if operation is None or operation.over or operation.limits is Limits.OWN or self._leaves_home():
            return
        if operation.limits is Limits.EITHER or limit_in(self.host, self.host.axis.direction):
            self.state.latches.fire(now_ns, "INP-02")
            self.state.latches.fire(now_ns, "POS-04", alone=True)
            self.host.cut(now_ns)

    def _leaves_home(self) -> bool:
        """Return whether the only active limit is the home switch and the axis is moving away from it."""
        axis, state = self.host.axis, self.state
        return (
            axis.capabilities.home_is_ccw_limit
            and axis.direction > 0
            and not state.active & CW_LIMIT
            and not state.risen & CCW_LIMIT
        )
