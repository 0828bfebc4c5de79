"""A 3601 under a random script, each of its images held against the contracts.

The bench does what a script of `stories3601` tells, with exchanges as far apart as it is told, and loses,
removes and breaks the module in between.
"""

from __future__ import annotations

from random import Random
from types import SimpleNamespace

import oracle_bits as bits
from oracle3601 import TICK_NS
from scanrack.io_images.amci3601 import InputBit, status_names
from scanrack.io_images.amci3601.contracts import CONTRACTS, Contract, Side
from scanrack.io_images.image import Image
from scanrack.runtime import Amci3601
from scanrack.runtime.loop.module_fault import ModuleFault
from scanrack.runtime.machine import EncoderSpec, Machine, MachineSpec, Switch

MOTION = bits.MOVING_CW | bits.MOVING_CCW
FREEZES = (ModuleFault.LINK_LOST, ModuleFault.ASIC_LOST)
TROUBLES = (None, *ModuleFault)
ONE_IN = 150
"""Exchanges from one fault of the module to the next, on average."""


class Broken(AssertionError):  # noqa: N818 - it is
    """A run broke a contract."""


class Watched:
    """A module alone, under the words, inputs and time of a script; stops at the first broken contract.

    Args:
        setting: the script's: firmware, switches, encoder.
        scan_ticks: ticks of the module's scan from exchange to exchange; None for the setting's.
        seed: of the faults; None for none.
    """

    def __init__(self, setting, scan_ticks, seed, check, options=None):
        switches = tuple(Switch(InputBit(bit), first, last) for bit, first, last in setting.switches)
        gear, every = setting.counts_per_step, setting.marker_every
        spec = MachineSpec(switches=switches, encoder=EncoderSpec(gear, marker_every=every) if gear else None)
        self.machine = Machine(spec)
        self.module = Amci3601(setting.firmware, self.machine, options, diagnostic_wiring=setting.wired_back)
        self.scan_ticks = scan_ticks or setting.scan_ticks
        self.random = None if seed is None else Random(seed)
        self.check = check
        self.wired = {bit for bit, _, _ in setting.switches}
        self.world = SimpleNamespace(hand_levels=0)
        self.words, self.outputs = [0] * 8, Image()
        self.now_ns = self.turned_until = 0
        self.running = True
        self.checked = 0
        self.inputs = tuple(self.module.update(0, self.outputs))
        self.look(None, None)

    @property
    def oracle(self):
        """What scripts ask about the module."""
        msw = 0 if self.inputs[0] < 0 else self.inputs[0]
        return SimpleNamespace(
            plc_running=self.running,
            config_error=bool(self.inputs[0] & bits.CONFIG_ERROR),
            position_invalid=bool(msw & bits.POSITION_INVALID),
            image=[msw, *self.inputs[1:]],
            in_motion=lambda: bool(msw & MOTION),
        )

    # ---- what a script does

    def out(self, words):
        self.words = list(words)
        self.outputs = Image(words)

    def input(self, bit, energized):
        if bit not in self.wired:
            self.machine.set_input(InputBit(bit), energized)
            self.module.look_again()
            self.world.hand_levels = self.world.hand_levels & ~bit | (bit if energized else 0)

    def turn(self, counts, ticks):
        if self.now_ns >= self.turned_until:
            self.turned_until = self.now_ns + ticks * TICK_NS
            self.machine.turn_encoder(counts, self.now_ns, self.turned_until)
            self.module.look_again()

    def marker(self, ticks):
        self.machine.marker_at(self.now_ns + ticks * TICK_NS)
        self.module.look_again()

    def plc(self, running):
        self.running = running
        self.module.plc_run(running)

    def power_cycle(self):
        self.module.power_cycle()

    # ---- time

    def run(self, ticks):
        for _ in range(-(-ticks // self.scan_ticks)):
            self.exchange()

    def run_to_rest(self, ticks):
        for _ in range(-(-ticks // self.scan_ticks)):
            self.exchange()
            if not self.oracle.in_motion():
                break

    def exchange(self):
        frozen = self.module.trouble in FREEZES
        if self.random is not None and self.random.randrange(ONE_IN) == 0:
            self.fault(self.random.choice(TROUBLES))
        frozen = frozen or self.module.trouble in FREEZES
        was, sent = self.inputs, tuple(self.outputs)
        self.now_ns += self.scan_ticks * TICK_NS
        self.inputs = tuple(self.module.update(self.now_ns, self.outputs))
        self.look(None if frozen else was, None if frozen else sent)

    def fault(self, trouble):
        if self.module.trouble is ModuleFault.FATAL_ERROR:
            self.module.power_cycle()
        self.module.inject(trouble)

    def look(self, was, sent):
        """Hold the image, with what was before unless the link was lost, against the contracts."""
        self.checked += 1
        wrong = self.check(self.inputs, was, sent)
        if wrong:
            images = [
                f"{name} {shown(image)}" for name, image in (("was", was), ("now", self.inputs)) if image
            ]
            names = ", ".join(row.name for row in wrong)
            raise Broken(f"{names}: {'; '.join(images)}; sent {sent} at {self.now_ns / 1e6} ms")


def shown(image):
    return f"{' '.join(status_names(image[0], image[1]))} {list(image[2:])}"


class Python:
    """The images as Python text: a fact becomes an expression over `was`, `now` and `sent`."""

    def any_of(self, side, word, mask):
        return f"({side.value}[{word}] & {mask} != 0)"

    def within(self, side, word, least, most):
        return f"({least} <= {side.value}[{word}] <= {most})"

    def both(self, first, second):
        return f"({first} and {second})"

    def negated(self, truth):
        return f"(not {truth})"


def check_of(rows: tuple[Contract, ...] = CONTRACTS):
    """Return a fast check of signed words: the rows that images break; `was` and `sent` may be None."""
    compiled = [(row, eval(f"lambda now, was, sent: {row.fact.read(Python())}")) for row in rows]
    alone = [(row, fact) for row, fact in compiled if row.fact.images == {Side.NOW}]

    def check(now, was, sent):
        if was is None:
            return [row for row, fact in alone if not fact(now, None, None)]
        return [row for row, fact in compiled if not fact(now, was, sent)]

    return check


CHECK = check_of()


def play(script, scan_ticks=None, seed=None, check=CHECK):
    """Play a script; return the number of images that were checked."""
    setting, steps = script
    bench = Watched(setting, scan_ticks, seed, check)
    for step in steps:
        step.play(bench)
    return bench.checked


# ---- without a plan

CONFIGURATIONS = (
    (0x843F, 0x3F),
    (0x853E, 0x3F),
    (0x847E, 0x3F),
    (0x957E, 0x3B),
    (0x863E, 0x3F),
    (0x843E, 0x0F),
    (0x8000, 0),
)
"""MSW and LSW: home switch, with encoder, with proximity, marker, feedback, active low, invalid."""

MACHINES = (
    (),
    ((bits.HOME, 300, 500),),
    ((bits.HOME, -400, -200), (bits.CW_LIMIT, 900, None), (bits.CCW_LIMIT, None, -900)),
    ((bits.CW_LIMIT, 500, None), (bits.CCW_LIMIT, None, -500)),
)
MSW = (0, 0, *(1 << bit for bit in range(15)), 0x200, 0x800, 0x800, 1, 2, 0x20, 0x40, 3)
LSW = (0,) * 20 + (1, 4, 0x80, 0x80, 0x100, 0x300, 0x400, 0x1000, 0x1000)
TARGETS = ((0, 400), (0, -400), (2, 0), (-1, 0), (0, 0), (-1, 1))
SPEEDS = (*((5, 0),) * 4, (2, 0), (0, 500), (30, 0), (0, 0))
RATES = (*((1000, 1000),) * 4, (100, 100), (20, 10), (2001, 1))
WITHOUT_TARGET = 0x3860 | 0x0180
WITHOUT_MOTION = 0x3600
SCANS = (1, 1, 2, 8, 40, 400, 4000, 10_000)
LIFT = (None, None, *ModuleFault)


def wild(seed, exchanges, check=CHECK, options=None):
    """Write words, operate inputs, break the module at random; return the number of images checked."""
    dice = Random(seed)
    setting = SimpleNamespace(
        switches=dice.choice(MACHINES),
        counts_per_step=dice.choice((0, 1)),
        marker_every=dice.choice((None, 100)),
        firmware=dice.choice(("2.0", "3.1", "4.1", "4.1")),
        wired_back=False,
    )
    if not setting.counts_per_step:
        setting.marker_every = None
    bench = Watched(setting, 1, None, check, options)
    msw, lsw = dice.choice(CONFIGURATIONS)
    configuration = (msw, lsw, 1, 0, 0, 0, 0, 0)
    for _ in range(exchanges):
        _do_something(bench, dice, configuration)
        bench.scan_ticks = dice.choice(SCANS)
        bench.exchange()
    return bench.checked


def _do_something(bench, dice, configuration):
    what = dice.randrange(60)
    if what < 35:
        bench.out(_words(bench, dice, configuration))
    elif what < 50:
        bench.input(
            dice.choice((bits.EXTERNAL, bits.ESTOP, bits.HOME, bits.CW_LIMIT, bits.CCW_LIMIT, bits.CAPTURE)),
            dice.random() < 0.3,
        )
    elif what < 53:
        bench.turn(dice.choice((1, -5, 400)), dice.choice((4, 400)))
    elif what == 53:
        bench.plc(not bench.running)
    elif what == 54:
        bench.fault(dice.choice(LIFT))
    elif what == 55 and dice.random() < 0.3:
        bench.power_cycle()


def _words(bench, dice, configuration):
    """Mostly what a module in this state can take."""
    recover = dice.random()
    status = bench.inputs[0]
    if recover < 0.7 and status & bits.CONFIG_ERROR:
        return [word - (word >> 15 << 16) for word in configuration]
    if recover < 0.5 and (status < 0 or bench.words[0]):
        return [0, *bench.words[1:]]
    if recover < 0.4 and status & (bits.COMMAND_ERROR | bits.INVALID_PROFILE):
        return [0x0800, *(0,) * 7]
    if recover < 0.2 and status & bits.POSITION_INVALID:
        return [dice.choice((0x0200, 0x0020)), *(0,) * 7]
    msw, lsw = dice.choice(MSW), dice.choice(LSW)
    careful = dice.random() < 0.9
    target = (0, 0) if careful and msw & WITHOUT_TARGET else dice.choice(TARGETS)
    rest = (0, 0, 0, 0) if careful and msw & WITHOUT_MOTION else (*dice.choice(SPEEDS), *dice.choice(RATES))
    return [msw, lsw, *target, *rest]
