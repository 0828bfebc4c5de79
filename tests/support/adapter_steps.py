"""Steps beside those of `steps3601` that only an adapter knows: its line, its controller's power, haste."""

from __future__ import annotations

from dataclasses import dataclass

from steps3601 import Recover


@dataclass(frozen=True)
class LinkLoss:
    """The line is cut for a while, words come meanwhile, and the controller may lose its power, too."""

    words: tuple[int, ...]
    loses_power: bool
    ms: int = 750

    def play(self, bench):
        bench.link_loss(self.ms, self.words, self.loses_power)


@dataclass(frozen=True)
class DevicePower:
    """The controller's power is cycled, the adapter's is not."""

    def play(self, bench):
        bench.device_power()


@dataclass(frozen=True)
class Disturb:
    """Replies get lost, and damaged: no more than two in a row, which must not be noticed."""

    lost: int
    damaged: int

    def play(self, bench):
        bench.disturb(self.lost, self.damaged)


@dataclass(frozen=True)
class Haste:
    """Words that follow each other faster than anything can go over the line: words and scans, each."""

    images: tuple[tuple[tuple[int, ...], int], ...]

    def play(self, bench):
        bench.haste(self.images)


@dataclass(frozen=True)
class PutRight:
    """What `Recover` does, with the configuration of the setting."""

    def play(self, bench):
        Recover(bench.setting.configuration).play(bench)
