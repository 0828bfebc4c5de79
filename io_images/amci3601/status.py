"""The 3601's status: the eight input words in command mode and configuration mode.

    word  command mode                        configuration mode
    0     status MSW                          mirror, but bits 13 to 15 are status
    1     status LSW                          mirror
    2, 3  current position, steps             mirror
    4, 5  encoder or diagnostic count         0
    6     captured value MSW                  firmware, major
    7     captured value LSW                  firmware, minor

Bit 15 of word 0 is the mode. Bits 6, 11 and 13 to 15 of the status LSW are reserved and read 0.

`Status` and `ConfigurationStatus` have the values of one image; `StatusView` reads its image at each access.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from ..dataclass import dataclass
from ..image import Image
from ..module_words import BitPlace
from ..thousands import LSW_MAX, REPORTED_MAX, join_reported, split_reported
from .bits import LIVE_BITS, StatusLsw, StatusMsw
from .firmware import Firmware
from .parameters import require

_MODE = StatusMsw.MODE_CONFIG.value
_MODULE_OK = StatusMsw.MODULE_OK.value
_CONFIG_ERROR = StatusMsw.CONFIG_ERROR.value
_RESERVED = 0xFFFF & ~sum(bit.value for bit in StatusLsw)

_Fields = tuple[tuple[str, int], ...]
_MSW_FIELDS: _Fields = tuple((str(bit.name).lower(), bit.value) for bit in StatusMsw if bit.value != _MODE)
_LSW_FIELDS: _Fields = tuple((str(bit.name).lower(), bit.value) for bit in StatusLsw)


@dataclass(frozen=True, slots=True, kw_only=True)
class Status:
    """An input image in command mode; all fields except the last three are bits [chapter 6, Status Bits].

    >>> status = Status.from_image(Image([0x4480, 0, -12, -345]))
    >>> status.move_complete, status.position_invalid, status.moving_cw, status.position
    (True, True, False, -12345)

    Raises:
        ValueError: one of the last three fields is out of range.
    """

    moving_cw: bool = False
    moving_ccw: bool = False
    hold_state: bool = False
    stopped: bool = False
    at_home: bool = False
    accelerating: bool = False
    decelerating: bool = False
    move_complete: bool = False
    home_invalid: bool = False
    invalid_profile: bool = False
    position_invalid: bool = False
    input_error: bool = False
    command_error: bool = False
    config_error: bool = False
    module_ok: bool = False
    in_capture: bool = False
    in_external: bool = False
    in_home: bool = False
    in_estop: bool = False
    in_cw_limit: bool = False
    in_ccw_limit: bool = False
    enc_follower: bool = False
    blend_running: bool = False
    blend_ack: bool = False
    min_reg_nonzero: bool = False
    home_prox_echo: bool = False
    position: int = 0  # current position, steps, -65,535,999 to 65,535,999
    encoder: int = 0  # encoder or diagnostic feedback count, in the same range
    captured: int = 0  # the value stored by the capture input, in the same range

    def __post_init__(self) -> None:
        for name, value in zip(("position", "encoder", "captured"), self._values(), strict=True):
            require(name, value, -REPORTED_MAX, REPORTED_MAX)

    def to_image(self) -> Image:
        """Return the input image."""
        values = [word for value in self._values() for word in split_reported(value)]
        return Image((self._word(_MSW_FIELDS), self._word(_LSW_FIELDS), *values))

    def _values(self) -> tuple[int, int, int]:
        return self.position, self.encoder, self.captured

    def _word(self, fields: _Fields) -> int:
        """Return a status word: the sum of the masks of the fields that are true."""
        return sum(mask for name, mask in fields if getattr(self, name))

    @classmethod
    def from_image(cls, image: Image) -> Status:
        """Read an input image in command mode.

        A position beyond ±32,767,999 with an LSW of 0 is read with the opposite sign; see
        `thousands.join_reported`.

        Raises:
            ValueError: the image is in configuration mode, a reserved bit is set, or an LSW is beyond ±999.
        """
        words = image.words.tolist()
        if words[0] & _MODE:
            raise ValueError(f"word 0 is {words[0] & 0xFFFF:04X}h: the module is in configuration mode")
        if words[1] & _RESERVED:
            raise ValueError(f"word 1 is {words[1] & 0xFFFF:04X}h: bits 6, 11 and 13 to 15 are reserved")
        for index in (3, 5, 7):  # the LSWs of position, encoder and captured value
            require(f"word {index}", words[index], -LSW_MAX, LSW_MAX)
        bits = {name: bool(words[0] & mask) for name, mask in _MSW_FIELDS}
        bits |= {name: bool(words[1] & mask) for name, mask in _LSW_FIELDS}
        return cls(
            position=join_reported(words[2], words[3]),
            encoder=join_reported(words[4], words[5]),
            captured=join_reported(words[6], words[7]),
            **bits,
        )


@dataclass(frozen=True, slots=True)
class ConfigurationStatus:
    """An input image in configuration mode [chapter 3, Configuration Mode Input Data].

    >>> ConfigurationStatus.from_image(Image([0xC43E, 0x003F, 1, 0, 0, 0, 4, 1]))  # doctest: +ELLIPSIS
    ConfigurationStatus(mirror=(1086, 63, 1, 0), config_error=False, module_ok=True, firmware=...)

    Raises:
        ValueError: the first word of the mirror has bits that are never mirrored.
    """

    mirror: tuple[int, int, int, int]  # the configuration in words 0 to 3, without bits 13 to 15 of word 0
    config_error: bool  # whether the module has no valid configuration
    module_ok: bool
    firmware: Firmware

    def __post_init__(self) -> None:
        if self.mirror[0] & LIVE_BITS:
            raise ValueError(
                f"mirror of word 0 is {self.mirror[0] & 0xFFFF:04X}h: bits 13 to 15 are not in the mirror"
            )

    def to_image(self) -> Image:
        """Return the input image."""
        live_bits = _MODE | self.module_ok * _MODULE_OK | self.config_error * _CONFIG_ERROR
        firmware = (self.firmware.major, self.firmware.minor)
        return Image((self.mirror[0] | live_bits, *self.mirror[1:], 0, 0, *firmware))

    @classmethod
    def from_image(cls, image: Image) -> ConfigurationStatus:
        """Read an input image; raise a ValueError if it is not in configuration mode."""
        words = image.words.tolist()
        if not words[0] & _MODE:
            raise ValueError(f"word 0 is {words[0] & 0xFFFF:04X}h: the module is in command mode")
        if words[4] or words[5]:
            raise ValueError(f"words 4 and 5 are {words[4]} and {words[5]}: in configuration mode they are 0")
        return cls(
            mirror=(words[0] & ~LIVE_BITS & 0xFFFF, words[1], words[2], words[3]),
            config_error=bool(words[0] & _CONFIG_ERROR),
            module_ok=bool(words[0] & _MODULE_OK),
            firmware=Firmware(words[6], words[7]),
        )


def _bit(word: int, mask: int) -> bool:
    """Return a property that is true if a bit of status word 0 or 1 is set; type checkers see a bool.

    In configuration mode, bits 0 to 12 of word 0 mirror the configuration, so they are not status bits.
    """
    checked_bits = mask if mask & LIVE_BITS else mask | _MODE

    def from_msw(view: StatusView) -> bool:
        msw: int = view._words[0]
        return msw & checked_bits == mask

    def from_lsw(view: StatusView) -> bool:
        msw: int = view._words[0]
        lsw: int = view._words[1]
        return lsw & mask != 0 and msw >= 0

    return property(from_lsw if word else from_msw)  # type: ignore[return-value]  # it reads as a bool


class StatusView:
    """The status bits and values of an input image, read at each access.

    Attributes have the same names as the bits in traces and tag addresses. In configuration mode, most of the
    image is a mirror: only MODE_CONFIG, MODULE_OK and CONFIG_ERROR can be true, and position, encoder and
    captured have no meaning.

    >>> image = Image()
    >>> view = StatusView(image)
    >>> image[0], image[2], image[3] = 0x4080, -12, -345
    >>> view.MOVE_COMPLETE, view.COMMAND_ERROR, view.position
    (True, False, -12345)
    """

    __slots__ = ("_words",)
    _names: ClassVar[tuple[str, ...]] = tuple(str(bit.name) for bit in (*StatusMsw, *StatusLsw))

    def __init__(self, image: Image) -> None:
        self._words = image.words

    def __repr__(self) -> str:
        on_names = " ".join(name for name, is_on in self._bits() if is_on) or "no bit"
        return f"<StatusView {on_names}, position {self.position:,}>"

    def _repr_html_(self) -> str:
        """Return the status as HTML for a notebook: its bits as chips, and the position."""
        from ..static_html import card, chips, line

        return card("3601", line(f"position {self.position:,}"), chips(self._bits()))

    def _bits(self) -> list[tuple[str, bool]]:
        return [(name, getattr(self, name)) for name in self._names]

    MOVING_CW = _bit(0, StatusMsw.MOVING_CW.value)
    MOVING_CCW = _bit(0, StatusMsw.MOVING_CCW.value)
    HOLD_STATE = _bit(0, StatusMsw.HOLD_STATE.value)
    STOPPED = _bit(0, StatusMsw.STOPPED.value)
    AT_HOME = _bit(0, StatusMsw.AT_HOME.value)
    ACCELERATING = _bit(0, StatusMsw.ACCELERATING.value)
    DECELERATING = _bit(0, StatusMsw.DECELERATING.value)
    MOVE_COMPLETE = _bit(0, StatusMsw.MOVE_COMPLETE.value)
    HOME_INVALID = _bit(0, StatusMsw.HOME_INVALID.value)
    INVALID_PROFILE = _bit(0, StatusMsw.INVALID_PROFILE.value)
    POSITION_INVALID = _bit(0, StatusMsw.POSITION_INVALID.value)
    INPUT_ERROR = _bit(0, StatusMsw.INPUT_ERROR.value)
    COMMAND_ERROR = _bit(0, StatusMsw.COMMAND_ERROR.value)
    CONFIG_ERROR = _bit(0, StatusMsw.CONFIG_ERROR.value)
    MODULE_OK = _bit(0, StatusMsw.MODULE_OK.value)
    MODE_CONFIG = _bit(0, StatusMsw.MODE_CONFIG.value)
    IN_CAPTURE = _bit(1, StatusLsw.IN_CAPTURE.value)
    IN_EXTERNAL = _bit(1, StatusLsw.IN_EXTERNAL.value)
    IN_HOME = _bit(1, StatusLsw.IN_HOME.value)
    IN_ESTOP = _bit(1, StatusLsw.IN_ESTOP.value)
    IN_CW_LIMIT = _bit(1, StatusLsw.IN_CW_LIMIT.value)
    IN_CCW_LIMIT = _bit(1, StatusLsw.IN_CCW_LIMIT.value)
    ENC_FOLLOWER = _bit(1, StatusLsw.ENC_FOLLOWER.value)
    BLEND_RUNNING = _bit(1, StatusLsw.BLEND_RUNNING.value)
    BLEND_ACK = _bit(1, StatusLsw.BLEND_ACK.value)
    MIN_REG_NONZERO = _bit(1, StatusLsw.MIN_REG_NONZERO.value)
    HOME_PROX_ECHO = _bit(1, StatusLsw.HOME_PROX_ECHO.value)

    @property
    def moving(self) -> bool:
        """Whether the axis is moving."""
        return self.MOVING_CW or self.MOVING_CCW

    @property
    def position(self) -> int:
        """Current position, steps."""
        return join_reported(self._words[2], self._words[3])

    @property
    def encoder(self) -> int:
        """Encoder or diagnostic feedback count."""
        return join_reported(self._words[4], self._words[5])

    @property
    def captured(self) -> int:
        """The value stored by the capture input."""
        return join_reported(self._words[6], self._words[7])


def view_with(further: Mapping[str, BitPlace]) -> type[StatusView]:
    """Return the view class of a module with further status bits as attributes."""
    if not further:
        return StatusView
    bits = {name: _bit(place.word, 1 << place.bit) for name, place in further.items()}
    return type("StatusView", (StatusView,), {"__slots__": (), "_names": (*StatusView._names, *bits), **bits})
