"""A controller some of whose replies have a wrong bit in what they say, not in their checksum."""

from __future__ import annotations


class NoisyDevice:
    """A device whose next replies are damaged; otherwise the one behind it.

    Attributes:
        damage_next: so many.

    Args:
        device: the one behind it.
        at: which byte of a reply suffers.
    """

    def __init__(self, device, at):
        self.device = device
        self.at = at
        self.damage_next = 0

    @property
    def line_format(self):
        return self.device.line_format

    @property
    def next_wake_ns(self):
        return self.device.next_wake_ns

    def receive(self, now_ns, data):
        self.device.receive(now_ns, data)

    def advance(self, now_ns):
        data = self.device.advance(now_ns)
        if not data or not self.damage_next:
            return data
        self.damage_next -= 1
        return bytes((*data[: self.at], data[self.at] ^ 0x04, *data[self.at + 1 :]))


def made_noisy(module, at):
    """Put noise on the line of an adapter's simulated controller; return what makes it."""
    faults = module.controller.line.faults
    faults.device = NoisyDevice(faults.device, at)
    return faults.device
