"""Traffic on the wires: what is called whole is answered, whatever else comes before it."""

from hypothesis import find, given
from scanrack.io_images import strategies as wires
from scanrack.io_images.pmc006.frame import REPLY, decode
from scanrack.runtime import LineFormat, SerialBus
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.line.rtu import is_frame

MS = 1_000_000
RTU, PLAIN = LineFormat(38_400, "E"), LineFormat(9600)


def answers(device, line_format, pieces, quiet_ns):
    """What comes back for each piece, with quiet in front of each; None for silence."""
    bus = SerialBus(device)
    found = []
    for piece in pieces:
        bus.run_until(bus.now_ns + quiet_ns)
        bus.take()
        end_ns = bus.send(piece.data, line_format)
        bus.run_until(end_ns + quiet_ns)
        found.append(bus.take() or None)
    return found


@given(wires.line_traffic(wires.modbus_requests(1)))
def test_a_pcl601_answers_every_whole_request_and_no_exception(pieces):
    device = Pcl601(1)
    for piece, answer in zip(pieces, answers(device, RTU, pieces, 200 * MS), strict=True):
        if piece.whole:
            assert answer is not None
            assert is_frame(answer)
            assert answer[:2] == piece.data[:2]  # an exception would have bit 7 of the function set


@given(wires.line_traffic(wires.modbus_requests(2)))
def test_requests_of_another_unit_are_left_to_it(pieces):
    found = answers(Pcl601(1), RTU, [piece for piece in pieces if piece.whole], 200 * MS)
    assert found == [None] * len(found)


@given(wires.line_traffic(wires.pmc006_requests(1)))
def test_a_pmc006_answers_every_whole_frame(pieces):
    device = Pmc006(Pmc006Controller(address=1))
    for piece, answer in zip(pieces, answers(device, PLAIN, pieces, 300 * MS), strict=True):
        if piece.whole and device.controller.address == 1:
            assert answer is not None
            frame = decode(answer)
            assert frame is not None
            assert frame.second == REPLY


def test_traffic_shrinks_to_a_plain_question():
    assert find(wires.modbus_requests(1), lambda frame: True).hex(" ") == "01 11 c0 2c"
    assert find(wires.line_traffic(wires.modbus_requests(1)), lambda pieces: len(pieces) == 1) == [
        wires.Piece(bytes.fromhex("0111c02c"), whole=True)
    ]
