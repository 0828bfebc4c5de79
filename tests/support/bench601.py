"""A PCL601 on a serial line in virtual time, spoken to as a master would."""

from __future__ import annotations

from struct import pack, unpack

from scanrack.io_images.pcl601 import ROWS, Register
from scanrack.runtime import Contact, SerialBus
from scanrack.runtime.controllers.pcl601.line import FORMATS, Pcl601
from scanrack.runtime.line.rtu import Timing, crc, frame
from scanrack.runtime.machine.contacts import GROUND, OPEN

PORT_TIMING = Timing(gap_ns=5_000_000, by_length=True)
"""Framing for transports that do not keep the time between characters."""

MS = 1_000_000
SWITCH_TO_ASCII = bytes.fromhex("00 06 00 00 00 0b c9 dc")


def hexed(text):
    return bytes.fromhex(text)


class Bench601:
    """One unit and its master."""

    def __init__(self, **options):
        self.unit = Pcl601(**options)
        self.bus = SerialBus(self.unit)

    @property
    def controller(self):
        return self.unit.controller

    @property
    def position(self):
        """Physical position."""
        return self.controller.motor.position

    def wait(self, ms):
        self.bus.run_until(self.bus.now_ns + round(ms * MS))

    def exchange(self, data):
        """Send bytes; return what has been answered by 50 ms later, or sooner if something has."""
        self.wait(2)
        self.bus.take()
        end = self.bus.send(data, self.unit.line_format)
        self.bus.run_until(end + 2 * MS)
        while not self.bus.is_idle:
            due_ns = self.bus.next_event_ns()
            assert due_ns is not None
            self.bus.run_until(due_ns)
        return self.bus.take()

    def ask(self, text):
        """Send a frame given in hex without CRC; return the reply in hex without CRC, None for silence."""
        body = hexed(text)
        reply = self.exchange(body + crc(body))
        if not reply:
            return None
        assert crc(reply[:-2]) == reply[-2:]
        return reply[:-2].hex(" ")

    def write(self, register, value):
        """Write a register, both words of a pair; return the exception code, None if it was taken."""
        row = ROWS[register]
        words = pack("<i" if value < 0 else "<I", value) if row.words == 2 else pack("<H", value)
        data = b"".join(words[at : at + 2][::-1] for at in range(0, len(words), 2))
        pdu = pack(">BHHB", 0x10, row.address, row.words, len(data)) + data
        reply = self.exchange(frame(self.controller.values[Register.ADDRESS], pdu))
        return reply[2] if reply[1] & 0x80 else None

    def read(self, register):
        row = ROWS[register]
        own = self.controller.values[Register.ADDRESS]
        reply = self.exchange(frame(own, pack(">BHH", 3, row.address, row.words)))
        words = unpack(f">{row.words}H", reply[3:-2])
        value = sum(word << 16 * k for k, word in enumerate(words))
        return value - (1 << 32) if row.low < 0 and value >> 31 else value

    def code(self, code):
        """Write the command register; return the exception code, None if it was taken."""
        return self.write(Register.COMMAND, code)

    def set_up(self, accel=1000, base=500, top=2000, jog=2000, direction=1):
        for register, value in (
            (Register.ACCEL, accel),
            (Register.BASE_SPEED, base),
            (Register.MAX_SPEED, top),
            (Register.JOG_SPEED, jog),
            (Register.DIRECTION, direction),
        ):
            assert self.write(register, value) is None

    def go(self, steps):
        self.write(Register.STEPS, steps)
        self.code(1)

    def go_to(self, position):
        self.write(Register.ABS_TARGET, position)
        self.code(1)

    def pin(self, name, contact="ground"):
        contacts = {"ground": GROUND, "open": OPEN}
        self.controller.pins.connect(name, contacts.get(contact, contact))
        self.controller.settle(self.bus.now_ns)

    def ge(self, name, position):
        self.pin(name, Contact(low=position))

    def le(self, name, position):
        self.pin(name, Contact(high=position))

    def errors(self):
        return self.read(Register.ERROR_CODE)

    def busy(self):
        return bool(self.read(Register.BUSY))

    def to_ascii(self):
        assert self.exchange(SWITCH_TO_ASCII) == b""
        assert self.unit.line_format == FORMATS[self.controller.protocol]

    def talk(self, *lines):
        """Send lines, CR added; return the text answered to the last one, None for silence."""
        replies = [self.exchange(line.encode("latin-1") + b"\r") for line in lines]
        return replies[-1].decode("ascii") or None
