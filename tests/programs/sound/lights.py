from scanrack import Counter, Fall, Input, InputWord, Logic, OffDelay, OnDelay, Output, OutputWord, Pulse, Rise


class Lights(Logic):
    start = Input("Local:2:I.Data.0")
    stop = Input("Local:2:I.Data.1")
    sensor = Input("Local:2:I.Data.2")
    raw = InputWord("Local:2:I.Data[0]")
    lamp: Output = Output("Local:3:O.Data.0")
    horn: Output = Output("Local:3:O.Data.1")
    fan: Output = Output("Local:3:O.Data.2")
    full: Output = Output("Local:3:O.Data.3")
    late = OnDelay("2 s")
    cooling = OffDelay("30 s")
    beep = Pulse("500 ms")
    pieces = Counter(12)
    pressed = Rise()
    released = Fall()
    run = False
    bits = 0
    message = ""

    def every_scan(self) -> None:
        if self.pressed(self.start) and not self.stop:
            self.run = True
        if self.stop:
            self.run = False
        self.lamp = self.run
        self.horn = self.beep(self.late(self.run and not self.sensor))
        self.fan = self.cooling(self.run)
        self.full = self.pieces(self.sensor, reset=self.released(self.start))
        self.bits = self.raw & 0xFF
        self.message = "running" if self.run else "stopped"
