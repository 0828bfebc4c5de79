"""One rack under a random script, twice: with scans by rows and with every scan by its phases.

The script is played piece by piece on a rack without look-ahead (`Rig.play`), which also tells at which scan
each action came. Then every rack runs in one go, and a listener acts at those scans, in the middle of a
block. Slot 1 is the script's module; the others show that rows hold for a whole rack.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import oracle_bits as bits
from scanrack.io_images.amci3601 import Direction, Idle, InputBit, Manual
from scanrack.io_images.image import Image
from scanrack.runtime import Amci3601, Card, Cpu, CpuMode, FaultKind, InjectedFault, Rack
from scanrack.runtime.loop.exchange import EndOfScan, EveryRpi, Exchange
from scanrack.runtime.loop.exposed import ExposedModule
from scanrack.runtime.loop.key_switch import KeySwitch
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.machine import EncoderSpec, Jam, Machine, MachineSpec, Slip, Switch
from scanrack.runtime.modules.cards.card_options import Cam, CardOptions, InputPress
from scanrack.runtime.modules.cards.module import GenericCard
from scanrack.traces import ScanRecorder, SlotInfo

TICK_NS = 250_000
SECOND_SLOT = ((0x843F, 0x003F, 1, 0, 0, 0, 0, 0), Idle(), Manual(Direction.CCW, 1200, 30, 30))
"""What the second 3601 is told in the first scans: it turns for ever, slowly."""

CARD = CardOptions(
    inputs={"here": 0, "beyond": 1, "short": 2, "home": 3, "start": 4},
    outputs={"lamp": 0},
    normally_closed=("beyond",),
    cam=(
        Cam(input="here", slot=1, first=40, last=77),
        Cam(input="beyond", slot=1, first=300),
        Cam(input="short", slot=1, last=-100),
        Cam(input="home", slot=1, switch="home"),
    ),
    timeline=(InputPress(at_ms=Decimal("777.5"), input="start", for_ms=Decimal(100)),),
)

Action = Callable[["Rig"], None]


@dataclass(frozen=True)
class World:
    """What a rack is made of.

    Attributes:
        setting: the script's own setting: firmware, switches, encoder.
        period_ns: from scan to scan.
        rpi_ns: of a CompactLogix; None = a MicroLogix.
        slips: of the machine of slot 1.
        jams: likewise.
        incidents: of slot 1, and turns of the key (slot 0).
        neighbors: whether there are a card with cams and a second 3601.
    """

    setting: Any
    period_ns: int = 2_000_000
    rpi_ns: int | None = None
    slips: Sequence[Slip] = ()
    jams: Sequence[Jam] = ()
    incidents: Sequence[InjectedFault] = ()
    neighbors: bool = False

    def rack(self) -> Rack:
        """Return the rack, powered up."""
        own = [each for each in self.incidents if each.slot == 1]
        stepper = self.stepper()
        module = ExposedModule(stepper, own) if own else stepper
        cards = [Card(1, module, "amci3601", self.setting.firmware)]
        if self.neighbors:
            panel = GenericCard(CARD)
            panel.join({1: stepper})
            cards += [Card(2, panel, "discrete16"), Card(4, Amci3601(), "amci3601", "4.1")]
        return Rack(cards)

    def stepper(self) -> Amci3601:
        """Return the module of slot 1 on its machine."""
        setting = self.setting
        switches = tuple(Switch(InputBit(bit), first, last) for bit, first, last in setting.switches)
        gear = setting.counts_per_step
        encoder = EncoderSpec(gear, marker_every=setting.marker_every) if gear else None
        spec = MachineSpec(switches=switches, encoder=encoder, slips=tuple(self.slips), jams=tuple(self.jams))
        return Amci3601(setting.firmware, Machine(spec, seed=5), None, diagnostic_wiring=setting.wired_back)


class Diary:
    """A listener that notes everything, and acts at the end of the scans it is told."""

    def __init__(self, rig: Rig, actions: Sequence[tuple[int, Action]]) -> None:
        self.rig = rig
        self.told: list[object] = []
        self._actions = list(reversed(actions))

    def event(self, scan, now_ns, topic, fields) -> None:
        self.told.append((scan, now_ns, topic, dict(fields)))

    def scan(self, scan, now_ns, flags) -> None:
        self.told.append((scan, now_ns, flags, bytes(self.rig.rack.memory)))
        while self._actions and self._actions[-1][0] == scan:
            self._actions.pop()[1](self.rig)

    def close(self) -> None:
        pass


class Rig:
    """A CPU on the rack of a world; satisfies what the steps of `steps3601` ask of a bench.

    Args:
        world: the rack.
        ahead: whether scans may go by rows.
        actions: what happens at the end of which scan.
        trace: where every scan is recorded; None = nowhere.
        made: makes the listeners, which then receive scans by rows, and the logic acts; None = a `Diary`.
    """

    def __init__(
        self,
        world: World,
        *,
        ahead: bool,
        actions: Sequence[tuple[int, Action]] = (),
        trace: Path | None = None,
        made: Callable[[Rig], list[ScanListener]] | None = None,
    ) -> None:
        self.made_of = world
        self.setting = world.setting
        self.rack = world.rack()
        self.diary = Diary(self, actions)
        self.actions: list[tuple[int, Action]] = []
        self.words = [0] * 8
        self.lamp = 0
        self.held = 0
        self.turned_until = 0
        self.due = [] if made is None else list(reversed(actions))
        listeners: list[ScanListener] = [self.diary] if made is None else made(self)
        if trace is not None:
            slots = [SlotInfo(slot.number, slot.catalog, slot.firmware) for slot in self.rack.slots.values()]
            listeners.insert(0, ScanRecorder(trace, self.rack.memory, slots, scan_period_ns=world.period_ns))
        exchange: Exchange = EndOfScan() if world.rpi_ns is None else EveryRpi(world.rpi_ns)
        self.cpu = Cpu(self.rack, self.logic, world.period_ns, exchange=exchange, listeners=listeners)
        self.cpu._ahead.enabled = ahead
        turns = [each for each in world.incidents if each.what is FaultKind.PROGRAM_MODE]
        if turns:
            self.cpu.add_listener(KeySwitch(self.cpu, turns))
        slot: Any = self.rack.slots[1].module
        self.stepper: Amci3601 = getattr(slot, "module", slot)  # inside of incidents
        self.exposed: Any = slot if isinstance(slot, ExposedModule) else None
        self.inputs = self.rack.slots[1].inputs
        self.fresh: list[bool] = []
        self.seen: list[tuple[int, int, int]] = []

    def logic(self, scan) -> None:
        """Write the words of the script; bring the second 3601 into its motion."""
        while self.due and self.due[-1][0] <= scan.number:
            self.due.pop()[1](self)
        self.fresh.append(scan.updated)
        scan.slot[1].outputs.load(Image(self.words))
        if 2 in scan.slot:
            scan.slot[2].outputs[0] = self.lamp
            told = SECOND_SLOT[min(scan.number, len(SECOND_SLOT) - 1)]
            scan.slot[4].outputs.load(Image(told) if isinstance(told, tuple) else told.to_image())

    # -- what a script does

    def act(self, action: Action) -> None:
        """Do something now, and note at the end of which scan that was."""
        self.actions.append((self.cpu.scan - 1, action))
        action(self)

    def out(self, words) -> None:
        self.act(lambda rig: rig.write(list(words)))

    def write(self, words) -> None:
        self.words = words
        self.lamp ^= 1

    def input(self, bit, energized) -> None:
        if bit not in {wired for wired, _, _ in self.setting.switches}:
            self.held = self.held & ~bit | (bit if energized else 0)
            self.act(lambda rig: rig.press(bit, energized))

    def press(self, bit, energized) -> None:
        self.stepper.machine.set_input(InputBit(bit), energized)
        self.stepper.look_again()

    def turn(self, counts, ticks) -> None:
        if self.cpu.now_ns < self.turned_until:
            return
        start_ns = self.cpu.now_ns
        self.turned_until = end_ns = start_ns + ticks * TICK_NS
        self.act(lambda rig: rig.stepper.machine.turn_encoder(counts, start_ns, end_ns))

    def marker(self, ticks) -> None:
        at_ns = self.cpu.now_ns + ticks * TICK_NS
        self.act(lambda rig: rig.stepper.machine.marker_at(at_ns))
        self.act(lambda rig: rig.stepper.look_again())

    def plc(self, running) -> None:
        self.act(lambda rig: setattr(rig.cpu, "mode", CpuMode.RUN if running else CpuMode.PROGRAM))

    def power_cycle(self) -> None:
        self.act(lambda rig: rig.rack.slots[1].module.power_cycle())

    def operate(self, bit, energized) -> None:
        """Act on an input; None gives it back to the machine."""
        self.act(lambda rig: rig.stepper.operate(bit, energized))

    def look(self) -> None:
        """Note shaft, encoder counts and inputs at the present."""
        self.act(lambda rig: rig.seen.append(rig.stepper.figures()))

    def happen(self, what, for_ns) -> None:
        """Let an incident come a little later, in a slot that is exposed to some already."""
        at_ns = self.cpu.now_ns + 12_345_678
        late = InjectedFault(at_ns, what, 1, for_ns)
        if self.exposed is not None:
            self.act(lambda rig: rig.exposed.happen(late))

    def force(self, address, value) -> None:
        """Hold a word or bit; None lets all go."""
        if value is None:
            self.act(lambda rig: rig.cpu.forces.clear())
        else:
            self.act(lambda rig: rig.cpu.forces.set(address, value))

    # -- time

    def run(self, ticks) -> None:
        self.cpu.run(max(1, ticks * TICK_NS // self.made_of.period_ns))

    def run_to_rest(self, ticks) -> None:
        for _ in range(20):
            self.run(ticks // 20)
            if not self.in_motion():
                break

    # -- what `Recover` asks of an oracle

    @property
    def oracle(self) -> Rig:
        return self

    @property
    def world(self) -> Rig:
        return self

    @property
    def hand_levels(self) -> int:
        return self.held

    @property
    def plc_running(self) -> bool:
        return self.cpu.mode is CpuMode.RUN

    @property
    def image(self) -> list[int]:
        return self.inputs.words.tolist()

    @property
    def config_error(self) -> bool:
        return bool(self.inputs[0] & bits.CONFIG_ERROR)

    @property
    def position_invalid(self) -> bool:
        return bool(self.inputs[0] & bits.POSITION_INVALID)

    def in_motion(self) -> bool:
        return bool(self.inputs[0] & (bits.MOVING_CW | bits.MOVING_CCW))


def played(world: World, steps) -> Rig:
    """Play a script piece by piece, by phases."""
    rig = Rig(world, ahead=False)
    for step in steps:
        step.play(rig)
    rig.cpu.run(50)
    rig.cpu.close()
    return rig


def replayed(rig: Rig, *, ahead: bool, trace: Path | None = None) -> Rig:
    """Run the scans of a rig in one go, its actions at the ends of the same scans."""
    early = [action for scan, action in rig.actions if scan < 0]
    twin = Rig(rig.made_of, ahead=ahead, actions=[pair for pair in rig.actions if pair[0] >= 0], trace=trace)
    for action in early:
        action(twin)
    twin.cpu.run(rig.cpu.scan)
    twin.cpu.close()
    return twin
