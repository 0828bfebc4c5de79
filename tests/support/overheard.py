"""What an adapter puts on its line, frame by frame."""

from __future__ import annotations

from adapterbench import AdapterBench


class Overheard:
    """Listens in from now on, for as long as the bench lives.

    Attributes:
        frames: each with its line format.

    Args:
        bench: whose line it is.
    """

    def __init__(self, bench: AdapterBench) -> None:
        line = bench.module.controller.line
        send = line.send
        self.frames: list[tuple[bytes, str]] = []

        def overheard(data, line_format):
            self.frames.append((data, str(line_format)))
            send(data, line_format)

        line.send = overheard  # type: ignore[method-assign]
