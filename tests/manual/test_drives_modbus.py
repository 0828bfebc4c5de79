"""Modbus of AMCI's networked drives [SMD p. 120, p. 121], and `scanrack drive` of a stack."""

from __future__ import annotations

import json
from struct import pack, unpack

import pytest
from drive_unit import ENABLE, VALID, Unit
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.drives.models import MODELS
from scanrack.jobs.drive.drive_bench import DriveBench
from scanrack.jobs.drive.requests import RequestError
from scanrack.runtime.modules.drives.drive import DriveUnit
from scanrack.runtime.modules.drives.registers import DriveRegisters

pytestmark = pytest.mark.rules


class Stack:
    """Drives behind their registers."""

    def __init__(self, model: str = "smd23e2", axes: int = 1) -> None:
        self.axes = [DriveUnit(MODELS[model]) for _ in range(axes)]
        self.registers = DriveRegisters(self.axes)

    def ask(self, form: str, *values: int) -> bytes:
        """Send a request of a form of struct."""
        return self.registers.answer(pack(">" + form, *values))

    def read(self, address: int, count: int, function: int = 4) -> tuple[int, ...]:
        """Read registers."""
        answer = self.ask("BHH", function, address, count)
        assert answer[:2] == bytes((function, 2 * count))
        return unpack(f">{count}H", answer[2:])

    def write(self, address: int, *values: int) -> None:
        """Write registers."""
        count = len(values)
        answer = self.ask(f"BHHB{count}H", 16, address, count, 2 * count, *values)
        assert answer == pack(">BHH", 16, address, count)

    def configure(self, first: int = 1024) -> None:
        """Configure and enable an axis."""
        self.write(first, *VALID)
        self.write(first, 0, ENABLE, *(0,) * 8)


class TestMap:
    def test_inputs_are_input_and_holding_registers_from_0(self):
        stack = Stack()
        assert stack.read(0, 10) == stack.read(0, 10, function=3) == (0x6408, *(0,) * 9)

    def test_outputs_are_holding_registers_from_1024(self):
        stack = Stack()
        stack.write(1026, 12, 345)
        assert stack.read(1024, 10, function=3) == (0, 0, 12, 345, *(0,) * 6)

    def test_discrete_inputs_are_the_bits_of_the_inputs(self):
        answer = Stack().ask("BHH", 2, 0, 16)
        assert answer == bytes((2, 2, 0x08, 0x64))

    def test_coils_are_the_bits_of_the_outputs(self):
        stack = Stack()
        stack.write(1024, 0x0204, 0x8000)
        assert stack.ask("BHH", 1, 16_384, 32) == bytes((1, 4, 0x04, 0x02, 0x00, 0x80))

    def test_function_5_writes_a_bit(self):
        stack = Stack()
        stack.configure()
        assert stack.ask("BHH", 5, 16_384 + 10, 0xFF00) == pack(">BHH", 5, 16_394, 0xFF00)
        assert stack.read(1, 1)[0] & 0x2000
        stack.ask("BHH", 5, 16_384 + 10, 0)
        assert not stack.read(1, 1)[0] & 0x2000

    def test_function_15_writes_bits(self):
        stack = Stack()
        assert stack.ask("BHHBBB", 15, 16_384 + 16, 16, 2, 0x01, 0x80) == pack(">BHH", 15, 16_400, 16)
        assert stack.read(1025, 1, function=3) == (0x8001,)

    def test_function_22_writes_under_a_mask(self):
        stack = Stack()
        stack.write(1025, 0x00F0)
        assert stack.ask("BHHH", 22, 1025, 0x7FFF, 0x8000) == pack(">BHHH", 22, 1025, 0x7FFF, 0x8000)
        assert stack.read(1025, 1, function=3) == (0x80F0,)

    def test_function_23_answers_with_the_data_from_before_its_write(self):
        stack = Stack()
        stack.write(1024, *VALID)
        assert stack.ask("BHHHHBH", 23, 0, 1, 1024, 1, 2, 0) == pack(">BBH", 23, 2, 0x8000)
        assert stack.read(0, 1)[0] & 0x8000 == 0
        assert stack.ask("BHHHHBH", 23, 1026, 1, 1026, 1, 2, 5) == pack(">BBH", 23, 2, VALID[2])


@pytest.mark.parametrize(
    ("form", "values", "code"),
    [
        ("B", (7,), 1),
        ("B", (43,), 1),
        ("BHH", (4, 10, 1), 2),
        ("BHH", (4, 9, 2), 2),
        ("BHH", (4, 1024, 1), 2),
        ("BHH", (3, 1034, 1), 2),
        ("BHH", (3, 1020, 8), 2),
        ("BHH", (1, 0, 1), 2),
        ("BHH", (1, 16_544, 1), 2),
        ("BHH", (2, 160, 1), 2),
        ("BHH", (6, 0, 1), 2),
        ("BHH", (6, 1034, 1), 2),
        ("BHH", (5, 10, 0xFF00), 2),
        ("BHHBHH", (16, 1033, 2, 4, 0, 0), 2),
        ("BHHHHBH", (23, 10, 1, 1024, 1, 2, 0), 2),
        ("BHHHHBH", (23, 0, 1, 0, 1, 2, 0), 2),
        ("BHHH", (22, 0, 0, 0), 2),
        ("BHH", (4, 0, 0), 3),
        ("BHH", (4, 0, 126), 3),
        ("BHH", (2, 0, 2001), 3),
        ("BHH", (5, 16_384, 0x1234), 3),
        ("BHHBH", (16, 1024, 1, 4, 0), 3),
        ("BH", (4, 0), 3),
        ("B", (16,), 3),
    ],
)
def test_smd_p121_exceptions(form, values, code):
    stack = Stack()
    stack.write(1024, 0x1234)
    assert stack.ask(form, *values) == bytes((values[0] | 0x80, code))
    assert stack.read(1024, 10, function=3) == (0x1234, *(0,) * 9)


@given(pdu=st.binary(min_size=1, max_size=40))
def test_any_bytes_are_answered(pdu):
    answer = Stack().registers.answer(pdu)
    assert answer[0] in (pdu[0], pdu[0] | 0x80)


def test_anf2_a_stack_of_axes():
    stack = Stack("anf2", axes=12)
    stack.write(1024 + 110, 0x8400, 0, 0, 100, *(0,) * 6)
    stack.write(1024 + 110, *(0,) * 10)
    stack.write(1024 + 110, 0x0002, 0, 0xFFFF, 0xFFFF, 0, 1000, 20, 20, 0, 0)
    for axis in stack.axes:
        axis.advance(1_000_000_000)
    assert stack.read(112, 2) == (0xFFFF, 0xFFFF)  # -1, the high word first
    assert stack.read(2, 2) == (0, 0)


class TestBench:
    def bench(self, model: str = "smd23e2") -> DriveBench:
        return DriveBench(MODELS[model])

    def ask(self, bench: DriveBench, **request: object) -> dict[str, object]:
        return bench.answer(json.dumps(request))

    def test_a_frame_is_answered_with_its_number_and_unit(self):
        reply = self.ask(self.bench(), tx="12 34 00 00 00 06 01 04 00 00 00 01")
        assert reply["rx"] == "12 34 00 00 00 05 01 04 02 64 08"

    @pytest.mark.parametrize("tx", ["12 34 00 01 00 06 01 04 00 00 00 01", "12 34 00 00 00 06 01 04", "00"])
    def test_what_is_no_frame_is_not_answered(self, tx):
        assert self.ask(self.bench(), tx=tx)["rx"] is None

    def test_inputs_follow_a_range_of_the_shaft(self):
        bench = self.bench()
        assert self.ask(bench, env={"in1": {"on_when_pos_in": [0, None]}})["t_ms"] == 0
        self.ask(bench, for_ms=1)
        assert bench.axes[0].inputs()[1] & 1
        self.ask(bench, env={"in1": "off"}, for_ms=1)
        assert not bench.axes[0].inputs()[1] & 1

    def test_the_surroundings(self):
        bench = self.bench()
        self.ask(bench, env={"temperature_c": 95, "cable": "lost", "encoder_error": True}, for_ms=1)
        self.ask(bench, env={"cable": "connected", "driver_fault": True, "connection": "lost", "stall": True})
        assert bench.axes[0].inputs()[1] & 0x1050 == 0x1050

    def test_power_and_figures(self):
        bench = self.bench()
        reply = self.ask(bench, power_cycle=True, observe=["position", "encoder_counts", "flash_writes"])
        assert reply["values"] == {"position": 0, "encoder_counts": 0, "flash_writes": 0}

    @pytest.mark.parametrize(
        ("request_", "says"),
        [
            ({"new": {"axes": 2}}, "new.axes: 2 is too many: must be 1 to 1"),
            ({"new": {"options": {"color": 1}}}, "option color: the simulated drive has no such option"),
            ({"new": {"options": {"stored": [1]}}}, "option stored"),
            ({"axis": 2}, "axis: 2 does not exist: must be 1 to 1"),
            ({"env": {"home": "on"}}, "env.home: the SMD23E2 has in1, in2"),
            ({"env": {"in3": "on"}}, "env.in3: unknown key; choose from in1"),
            ({"env": {"in1": {"on_when_pos_in": [5, 1]}}}, "must not be above the last"),
            ({"tx": "zz"}, 'tx: "zz" is not allowed'),
        ],
    )
    def test_a_bad_request_names_key_value_and_what_is_allowed(self, request_, says):
        with pytest.raises(RequestError, match=says.replace("[", r"\[")):
            self.ask(self.bench(), **request_)

    def test_a_stack(self):
        bench = self.bench("anf2")
        self.ask(bench, new={"axes": 12})
        assert len(bench.axes) == 12
        self.ask(bench, axis=12, env={"cw_limit": "on"})


class TestModels:
    @pytest.mark.parametrize("name", sorted(MODELS))
    def test_names_of_words_and_bits(self, name):
        words = MODELS[name].words
        assert len(words.outputs) == len(words.inputs) == 10
        assert words.groups["status"]["MODULE_OK"][1:] == (0, 14)
        reset = 11 if name == "anf2" else 10
        assert words.groups["command"]["RESET_ERRORS"][1:] == (0, reset)

    def test_sd_p55_p58_current_keys(self):
        unit = Unit("sd17060e2").configure({8: 28}).preset()
        unit.command(2, (0, 9), current=40, modifiers=0x21, ms=50)
        assert unit.word(8) == 40
        unit.command(2, (0, 9), current=40, ms=50)
        assert unit.word(8) == 28
        assert "CMD-03" in unit.command(2, (0, 9), current=41, modifiers=0x21).rules

    def test_anf2_reset_errors_is_bit_11(self):
        unit = Unit("anf2").write(0x8400, 0, 0, 100, 0, 0, 0, 0, 0, 0).write(*(0,) * 10).write(4)
        assert "COMMAND_ERROR" in unit.status
        unit.write(0x0800)
        assert unit.word(0) == 0x4408

    def test_anf2_needs_no_enable_bit_and_forgets_its_configuration(self):
        unit = Unit("anf2").write(0x8400, 0, 0, 100, 0, 0, 0, 0, 0, 0)
        assert unit.word(0) == 0x4408
        unit.write(*(0,) * 10).write(2, 0, 0, 500, 0, 1000, 20, 20, 0, 0, ms=900)
        assert unit.word(0) == 0x4488
        unit.drive.power_cycle()
        assert unit.word(0) == 0x6408

    def test_anf2_limits_are_bits_3_and_4(self):
        unit = Unit("anf2").write(0x8428, 0x0018, 0, 100, 0, 0, 0, 0, 0, 0).write(*(0,) * 10)
        for at, bit in ((3, 0x08), (4, 0x10)):
            unit.drive.operate(unit.drive.terminals[at], True)
            assert unit.wait(1).word(1) == bit
            unit.drive.operate(unit.drive.terminals[at], False)
