"""The labeller and the blend path of the examples against the same programs in rungs, scan by scan.

With late judging, as rungs have it, every image of the 3601 is the same. As the examples are, results come a
scan earlier: the same images in the same order, sooner by the scans of `SOONER`.

An Execute that is on in the first scan is not an edge to a rung, so those sequences begin a scan later. A
timer whose rung stands above the one that starts it begins a scan later and is a scan shorter.
"""

from pathlib import Path

import pytest
from axis_lockstep import LateAxis
from scanrack import sequence, until
from scanrack.jobs import build_cpu, build_rack, load_job
from scanrack.ladder.files import parse_program

EXAMPLES = Path(__file__).parents[3] / "examples" / "sequences"
SCANS = {"labeller": 6_000, "blend_path": 4_500}

LABELLER = """\
PROGRAM labeller
USE axis3601
SLOT web : 1
ALIAS Refilled : Local:2:I.Data.0
ALIAS Applicator : Local:3:O.Data.0
ALIAS Empty : Local:3:O.Data.1
TAG Axis : AXIS_3601
TAG Module : Amci3601
TAG Words : INT[8] := [WORDS]
TAG Configure : Configure3601
TAG Minimum : StoreMinimum3601
TAG Run : MoveRegistration3601
TAG Halt : MC_Halt
TAG Step : DINT
TAG NoMark : TIMER
TAG Press : TIMER
TAG Limit : TIMER
TAG Before : BOOL
TAG Edge : BOOL
TAG Go : BOOL[5]
ROUTINE Main
XIO(S:FS)EQU(Step,0)MOV(1,Step);
EQU(Step,3)XIO(web.status.IN_EXTERNAL)TON(NoMark,20,0);
EQU(Step,3)XIC(NoMark.DN)MOV(4,Step);
EQU(Step,5)TON(Press,148,0);
EQU(Step,5)XIC(Press.DN)MOV(4,Step);
XIC(Refilled)ONS(Before)OTE(Edge);
EQU(Step,7)XIC(Edge)MOV(4,Step);
EQU(Step,1)OTE(Go[1]);
Configure3601(Configure,Axis,Words,Go[1]);
EQU(Step,1)XIC(Configure.Done)MOV(2,Step);
EQU(Step,2)OTE(Go[2]);
StoreMinimum3601(Minimum,Axis,Go[2],2000);
EQU(Step,2)XIC(Minimum.Done)MOV(3,Step);
EQU(Step,4)OTE(Go[3]);
MoveRegistration3601(Run,Axis,Go[3],600,3000,20,20);
EQU(Step,4)TON(Limit,2000,0);
EQU(Step,4)XIC(Run.Done)MOV(5,Step);
EQU(Step,4)XIC(Limit.DN)MOV(6,Step);
EQU(Step,5)OTE(Applicator);
EQU(Step,6)OTE(Go[4]);
MC_Halt(Halt,Axis,Go[4]);
EQU(Step,6)XIC(Halt.Done)MOV(7,Step);
EQU(Step,7)OTE(Empty);
Amci3601(Module,Axis,web.I.Data[0],web.O.Data[0]);
END
"""

BLEND_PATH = """\
PROGRAM blend
USE axis3601
SLOT card : 1
ALIAS Button : Local:2:I.Data.0
TAG Axis : AXIS_3601
TAG Module : Amci3601
TAG Words : INT[8] := [WORDS]
TAG Lengths : DINT[3] := [1000, 4000, 2000]
TAG Velocities : DINT[3] := [1000, 8000, 2000]
TAG Rates : INT[3] := [10, 50, 50]
TAG Configure : Configure3601
TAG Blend : ProgramBlend3601
TAG Run : RunBlend3601
TAG Step : DINT
TAG Way : INT := -1
TAG Before : BOOL
TAG Edge : BOOL
TAG Go : BOOL[4]
ROUTINE Main
XIO(S:FS)EQU(Step,0)MOV(1,Step);
XIC(Button)ONS(Before)OTE(Edge);
EQU(Step,3)XIC(Edge)MOV(4,Step)NEG(Way,Way);
EQU(Step,1)OTE(Go[1]);
Configure3601(Configure,Axis,Words,Go[1]);
EQU(Step,1)XIC(Configure.Done)MOV(2,Step);
EQU(Step,2)OTE(Go[2]);
ProgramBlend3601(Blend,Axis,Lengths,Velocities,Rates,Go[2],3,20);
EQU(Step,2)XIC(Blend.Done)MOV(3,Step);
EQU(Step,4)OTE(Go[3]);
RunBlend3601(Run,Axis,Go[3],Way);
EQU(Step,4)XIC(Run.Done)MOV(3,Step);
Amci3601(Module,Axis,card.I.Data[0],card.O.Data[0]);
END
"""

RUNGS = {"labeller": LABELLER, "blend_path": BLEND_PATH}
PARTS = {"labeller": ("web", "label"), "blend_path": ("axis", "path")}


class Outputs:
    """Keeps the output words of the 3601, and the outputs of the card in slot 3, if there is one."""

    def __init__(self, rack):
        self._rack = rack
        self.words = []

    def scan(self, scan, now_ns, flags):
        slots = self._rack.slots
        self.words.append((tuple(slots[1].outputs), slots[3].outputs[0] if 3 in slots else 0))

    def event(self, scan, now_ns, topic, fields):
        pass

    def close(self):
        pass


def run(name, make):
    """Run an example's rack with other logic, made of the example's own; return the words of every scan."""
    job = load_job(str(EXAMPLES / f"{name}.toml"))
    rack = build_rack(job.spec)
    outputs = Outputs(rack)
    with build_cpu(job.spec, make(name, job.logic), rack, listeners=[outputs]) as cpu:
        cpu.run(SCANS[name])
    return outputs.words


def in_rungs(name, example):
    axis = vars(type(example))[PARTS[name][0]]
    words = ", ".join(str(word) for word in axis.configuration.to_image())
    return parse_program(RUNGS[name].replace("WORDS", words, 1)).compile()


def a_scan_later(name, example, kind=None):
    """Return the example, begun in the second scan, its axis of another class."""
    part, method = PARTS[name]
    base = type(example)
    begun = vars(base)[method].function

    async def later(self):
        await until(lambda: True)
        await begun(self)

    axis = vars(base)[part]
    members = {method: sequence(later)}
    if kind is not None:
        members[part] = kind(axis.slot, axis.configuration)
    return type(base.__name__, (base,), members)()


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNGS)
def test_with_late_judging_every_image_is_the_same(name):
    rungs = run(name, in_rungs)
    python = run(name, lambda name, example: a_scan_later(name, example, LateAxis))
    assert [scan for scan in range(SCANS[name]) if rungs[scan] != python[scan]] == []
    assert len({words for words, _ in rungs}) >= 5


SOONER = {
    "labeller": [0] * 5 + [1] * 2 + [2] * 2 + [3] * 2 + [4] * 3 + [0] * 2 + [1] * 3,
    "blend_path": [0] * 4 + [1, 2, 3, 4, 5, 6, 7, 8] + [0] * 4,
}
"""Scans that each image of the 3601 comes sooner with early judging.

A command behind another one's end: none, since the wait for zeros hides it (configuration, minimum). The web
gains a scan at "no mark", one with each label's dwell, and none at a halt; at the refilled button, which is
pressed for both in one scan, it begins from 0 again. The blend gains one in each of eight phases (header and
three segments, each sent and acknowledged), and at the button it is even again.
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNGS)
def test_with_early_judging_the_same_images_come_sooner_by_a_scan_for_each_wait(name):
    late, early = changes(run(name, in_rungs)), changes(run(name, a_scan_later))
    assert [image for image, _ in late] == [image for image, _ in early]
    assert [scan - sooner for (_, scan), (_, sooner) in zip(late, early, strict=True)] == SOONER[name]


def changes(words):
    """Return each image of the 3601 that differs from the one before, with its scan."""
    images = [image for image, _ in words]
    return [(image, scan) for scan, image in enumerate(images) if scan == 0 or images[scan - 1] != image]
