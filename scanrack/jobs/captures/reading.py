"""Reads the exchanges with one controller from a capture or log."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from scanrack.io_images.captures.packets import PCAP_MAGICS, SECTION, Capture, CutFrames
from scanrack.io_images.captures.segments import Segment, segment_in
from scanrack.io_images.captures.streams import CONNECTIONS_MAX, Chunk, Streams
from scanrack.io_images.input_files import open_input

from .cip_pairing import CipPairing
from .pairing import ModbusTcpPairing, PairedExchange, Pairing, PmcPairing, RtuPairing
from .textlog import LINE_MAX, TextLog

MODBUS_PORT = 502
EXCHANGES_MAX = 2_000_000
PORTS_SHOWN = 8


@dataclass(slots=True)
class DeviceCapture:
    """The content of a file for one controller.

    Attributes:
        exchanges: the exchanges, in order of completion.
        notes: sentences about missing or ignored content.
    """

    exchanges: list[PairedExchange]
    notes: list[str] = field(default_factory=list)


def read_capture(
    path: Path, pairing: Callable[[], Pairing], port: int = MODBUS_PORT, unit: int | None = None
) -> DeviceCapture:
    """Read a capture (pcap or pcapng) or a log of frames.

    Args:
        pairing: creates the object that finds the exchanges of a connection.
        port: TCP port of the controller or its gateway.
        unit: unit address of the controller; None if the file has only one.

    Raises:
        ValueError: the file is missing or damaged, has no exchange with the controller, or has several units.
    """
    try:
        with open_input(path) as file:
            head = file.read(4)
            file.seek(0)
            captured = _read_exchanges(file, head, pairing, port)
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    return _select_unit(path, captured, unit)


def pairing_of(controller: str, *, rtu: bool) -> Callable[[], Pairing]:
    """Return the pairing for a controller: `pcl601`, `pmc006`, `amci3601` or `compactlogix`."""
    if controller == "compactlogix":
        return CipPairing
    if controller == "pmc006":
        return PmcPairing
    return RtuPairing if rtu else ModbusTcpPairing


def is_capture(head: bytes) -> bool:
    """Return whether a file that begins with `head` is a capture."""
    numbers = int.from_bytes(head, "big"), int.from_bytes(head, "little")
    return SECTION in numbers or any(number in PCAP_MAGICS for number in numbers)


def _read_exchanges(file: BinaryIO, head: bytes, pairing: Callable[[], Pairing], port: int) -> DeviceCapture:
    """Return the exchanges in a capture, or in a log of frames if the pairing can read one."""
    if is_capture(head):
        return _read_packets(Capture(file), pairing, port)
    if pairing is CipPairing:
        raise ValueError("not a capture")
    if pairing is ModbusTcpPairing:
        raise ValueError("not a capture; for a log of frames of a serial line, give --rtu-over-tcp")
    return _read_text(file, pairing())


class _Connections:
    """The latest connections with one controller in a capture.

    Attributes:
        capture: the exchanges so far.
    """

    def __init__(self, pairing: Callable[[], Pairing]) -> None:
        self._pairing = pairing
        self._pairings: OrderedDict[object, Pairing] = OrderedDict()
        self.capture = DeviceCapture([])

    def feed(self, chunk: Chunk, *, to_device: bool) -> None:
        """Process bytes of a connection."""
        connection = (chunk.source, chunk.target) if to_device else (chunk.target, chunk.source)
        if connection not in self._pairings:
            self._pairings[connection] = self._pairing()
        pairing = self._pairings[connection]
        self._pairings.move_to_end(connection)
        if len(self._pairings) > CONNECTIONS_MAX:
            _add(self.capture, self._pairings.popitem(last=False)[1].finish())
        _add(self.capture, pairing.feed(chunk.at_ns, chunk.data, to_device=to_device, fresh=chunk.after_gap))

    def finish(self) -> list[Pairing]:
        """End all connections and return their pairings."""
        for pairing in self._pairings.values():
            _add(self.capture, pairing.finish())
        return list(self._pairings.values())


def _read_packets(capture: Capture, pairing: Callable[[], Pairing], port: int) -> DeviceCapture:
    """Return the exchanges at a port in a capture; if there are none, raise ValueError with the reason."""
    streams, connections, other_ports = Streams(), _Connections(pairing), set[int]()
    captured = connections.capture
    cut = CutFrames()
    for chunk in streams.chunks(_segments(capture, port, cut)):
        to_device = chunk.target[1] == port
        if not to_device and chunk.source[1] != port:
            if len(other_ports) < PORTS_SHOWN:  # usually, the lower port is that of the server
                other_ports.add(min(chunk.source[1], chunk.target[1]))
            continue
        connections.feed(chunk, to_device=to_device)
    pairings = connections.finish()
    if not captured.exchanges:
        raise ValueError(
            _reason_without_exchange(port, other_ports, pairings, cut if cut.count else capture.cut_frames)
        )
    if capture.cut_off is not None:
        captured.notes.append(f"the file ends within a packet, at byte {capture.cut_off:,}")
    if cut.count:
        captured.notes.append(_cut_frames_text(cut))
    if streams.gaps:
        captured.notes.append(f"gaps in the captured bytes: {streams.gaps:,}")
    return captured


def _reason_without_exchange(
    port: int, other_ports: set[int], pairings: Iterable[Pairing], cut: CutFrames
) -> str:
    """Return the reason why a capture has no exchange at a port, as a sentence.

    Args:
        other_ports: other ports with connections in the capture.
        cut: counts of its truncated frames.
    """
    if cut.count:
        return f"no complete exchange at port {port}: {_cut_frames_text(cut)}"
    ports_seen = f"; its ports are {', '.join(map(str, sorted(other_ports)))}" if other_ports else ""
    passed_over = next(filter(None, (pairing.passed_over for pairing in pairings)), "")
    return passed_over or f"no exchange at port {port}{ports_seen}"


def _segments(capture: Capture, port: int, cut: CutFrames) -> Iterator[Segment]:
    """Yield the segments of a capture; count truncated frames of a port."""
    for packet in capture.packets():
        segment = segment_in(packet)
        if segment is not None:
            if segment.cut and port in (segment.source[1], segment.target[1]):
                cut.add(packet)
            yield segment


def _cut_frames_text(frames: CutFrames) -> str:
    return f"truncated frames: {frames}; capture whole frames, with a snap length of 0"


def _read_text(file: BinaryIO, pairing: Pairing) -> DeviceCapture:
    """Return the exchanges in a log of frames; raise ValueError if there are none."""
    log, captured = TextLog(), DeviceCapture([])
    for entry in log.entries(_lines(file)):
        _add(captured, pairing.feed(entry.at_ns, entry.data, to_device=entry.to_device, fresh=False))
    _add(captured, pairing.finish())
    if not captured.exchanges:
        raise ValueError("neither a capture nor a log of frames, such as 0.027 > 01 03 00 00 00 26 c5 d0")
    if log.passed_over:
        captured.notes.append(f"lines without a frame: {log.passed_over:,}")
    return captured


def _lines(file: BinaryIO) -> Iterator[str]:
    """Yield the lines of a text. Overlong lines are split into parts that do not count as frames."""
    while line := file.readline(LINE_MAX + 1):
        yield line.decode("utf-8", "replace").rstrip("\r\n")


def _add(captured: DeviceCapture, exchanges: Iterator[PairedExchange]) -> None:
    captured.exchanges.extend(exchanges)
    if len(captured.exchanges) > EXCHANGES_MAX:
        raise ValueError(f"more than {EXCHANGES_MAX:,} exchanges: split the capture")


def _select_unit(path: Path, captured: DeviceCapture, unit: int | None) -> DeviceCapture:
    """Keep one unit's exchanges, ordered by their ends; raise ValueError if it is missing or ambiguous."""
    units = sorted({exchange.unit for exchange in captured.exchanges})
    if unit is None and len(units) > 1:
        raise ValueError(f"{path}: several units ({', '.join(map(str, units))}): give --address")
    if unit is not None and unit not in units:
        raise ValueError(f"{path}: no unit {unit}; it has {', '.join(map(str, units))}")
    of_unit = (exchange for exchange in captured.exchanges if unit in (None, exchange.unit))
    captured.exchanges = sorted(of_unit, key=lambda each: each.answered_ns)
    unanswered = sum(exchange.reply is None for exchange in captured.exchanges)
    if unanswered:
        captured.notes.append(f"requests without a valid reply: {unanswered:,}")
    return captured
