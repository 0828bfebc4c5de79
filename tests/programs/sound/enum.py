from enum import IntEnum

from scanrack import Configuration, Idle, InputBit, Move, MoveKind, PresetPosition, ResetErrors, StatusView

SETTINGS = Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, starting_speed=500)
STATIONS = [0, 2000, 4000, 6000]


class Step(IntEnum):
    CONFIGURE = 0
    PRESET = 1
    WAIT = 2
    GO = 3
    TROUBLE = 9


class Machine:
    def __init__(self):
        self.step = Step.CONFIGURE
        self.next = 0
        self.pressed = False

    def scan(self, axis, button):
        status = StatusView(axis.inputs)
        if status.COMMAND_ERROR or status.INPUT_ERROR:
            self.step = Step.TROUBLE
        match self.step:
            case Step.CONFIGURE:
                self.configure(axis, status)
            case Step.PRESET:
                axis.outputs.load(PresetPosition(0).to_image())
                if not status.POSITION_INVALID:
                    axis.outputs.load(Idle().to_image())
                    self.step = Step.WAIT
            case Step.WAIT if button and not self.pressed:
                self.next = (self.next + 1) % len(STATIONS)
                axis.outputs.load(Move(MoveKind.ABSOLUTE, STATIONS[self.next], 3000, 10, 10).to_image())
                self.step = Step.GO
            case Step.GO if status.MOVE_COMPLETE:
                axis.outputs.load(Idle().to_image())
                self.step = Step.WAIT
            case Step.TROUBLE:
                axis.outputs.load(ResetErrors().to_image())
                if not status.COMMAND_ERROR and not status.INPUT_ERROR:
                    axis.outputs.load(Idle().to_image())
                    self.step = Step.WAIT
        self.pressed = button

    def configure(self, axis, status):
        axis.outputs.load(SETTINGS.to_image())
        if status.MODE_CONFIG and not status.CONFIG_ERROR:
            axis.outputs.load(Idle().to_image())
            self.step = Step.PRESET


machine = Machine()


def logic(scan):
    machine.scan(scan.slot[1], scan.slot[2].inputs.bit(0, 0))
    scan.slot[3].outputs.set_bit(0, 0, machine.step == Step.GO)
