"""What a card can't be or have in a rack file: the sentence names thing, value and what is allowed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from scanrack.runtime import RackFileError, load_rack_file

STEPPER = (
    '[[slot]]\nnumber = 1\nmodule = "amci3601"\n\n[slot.machine]\nswitches = [{ input = "home", last = 0 }]\n'
)


def rack(tmp_path: Path, *lines: str, head: str = 'program = "x.rung"', module: str = "1769-IQ16") -> Path:
    card = f'[[slot]]\nnumber = 2\nmodule = "{module}"\n'
    path = tmp_path / "rack.toml"
    path.write_text("\n".join([head, "scan_ms = 2", STEPPER, card, *lines]), encoding="utf-8")
    return path


def options(*lines: str) -> tuple[str, ...]:
    return ("[slot.options]", "inputs = { start = 0 }", *lines)


PRESS = "timeline = [{ at_ms = 10, input = 'start'%s }, { at_ms = 20, input = 'start' }]"


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (('firmware = "3.0"',), 'firmware = "3.0": a 1769-IQ16 has no firmware here: remove this key'),
        (options(PRESS % ""), "'start' is pressed at 20 ms, but also from 10 ms on"),
        (options(PRESS % ", for_ms = 11"), "also from 10 ms to 21 ms; presses must not overlap"),
        (options("outputs = { start = 0 }"), "'start' names an input and an output"),
        (
            options('cam = [{ input = "start", slot = 1, switch = "cw_limit" }]'),
            "the machine of slot 1 has no switch 'cw_limit'; its switches are home",
        ),
    ],
)
def test_what_a_card_can_not_have(tmp_path: Path, lines: tuple[str, ...], says: str) -> None:
    module = "discrete16" if "outputs" in "".join(lines) else "1769-IQ16"
    with pytest.raises(RackFileError, match=re.escape(says)):
        load_rack_file(rack(tmp_path, *lines, module=module))


def test_presses_one_after_the_other_and_a_switch_that_is_there_are_taken(tmp_path: Path) -> None:
    load_rack_file(rack(tmp_path, *options(PRESS % ", for_ms = 10")))
    load_rack_file(rack(tmp_path, *options('cam = [{ input = "start", slot = 1, switch = "home" }]')))


@pytest.mark.parametrize("head", ['program = "x.rung"\ncontroller = "micrologix"', 'program = "x.SLC"'])
def test_a_1769_card_does_not_fit_a_micrologix(tmp_path: Path, head: str) -> None:
    says = 'module = "1769-IQ16": this card does not fit a MicroLogix; choose from 1762-IQ8, 1762-IQ16'
    with pytest.raises(RackFileError, match=re.escape(says)):
        load_rack_file(rack(tmp_path, head=head))
    load_rack_file(rack(tmp_path, head=head, module="1762-IQ16"))


@pytest.mark.parametrize("head", ['program = "x.rung"\ncontroller = "compactlogix"', 'program = "x.L5X"'])
def test_a_1762_card_does_not_fit_a_compactlogix(tmp_path: Path, head: str) -> None:
    with pytest.raises(RackFileError, match=re.escape("does not fit a CompactLogix; choose from 1769-IQ16")):
        load_rack_file(rack(tmp_path, head=head, module="1762-IQ8"))
    load_rack_file(rack(tmp_path, head=head))
