"""Filters: transfer functions of s, executed by the bilinear transform with DeltaT.

    s = 2/DeltaT (1 - 1/z) / (1 + 1/z)

| block | transfer function |
|---|---|
| LDLG | (1 + Lead s) / (1 + Lag s), of In x Gain + Bias |
| LPF | w^n / B(s), w = WLag, B the Butterworth polynomial of order n = 1 to 3 |
| HPF | s^n / B(s), w = WLead |
| NTCH | (s^2 + w^2) / (s^2 + s w/Q + w^2), w = WNotch; order 4 is its square |
| LDL2 | C(WLead, ZetaLead) / C(WLag, ZetaLag), C(w, z) = 1 + 2 z s/w + (s/w)^2; order 1 without z: 1 + s/w |

DERV, INTG and DEDT are the derivative, the integral and a delay [1756-RM006K, the page of each]. The first
scan and Initialize start a filter in its steady state. A value that is NaN or infinite is not stored. After
such a value, LDLG, DERV, INTG and DEDT continue from the last stored values [Function Block Responses to
Overflow Conditions], and the other filters restart [p. 333, 345]. The manual has no difference equations, so
the equations here are interpretations, like the range of a frequency, 1E-7/DeltaT to 0.7 pi/DeltaT. LDL2
limits WLag to 40 WLead in order 1, and to 10 WLead in order 2 [p. 345].
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from ...interpreter.files import Elements
from .function_block import FunctionBlock, block_row

Polynomial = Sequence[float]
"""Coefficients of s^0, s^1, ..."""

_MOST_ORDER = 4
_SQRT2 = math.sqrt(2)
_BUTTERWORTH: dict[int, Polynomial] = {1: (1, 1), 2: (1, _SQRT2, 1), 3: (1, 2, 2, 1)}


def _times(a: Polynomial, b: Polynomial) -> list[float]:
    """Multiply polynomials."""
    product = [0.0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            product[i + j] += x * y
    return product


def _in_delays(polynomial: Polynomial, order: int, seconds: float) -> list[float]:
    """Convert a polynomial of s to a polynomial of 1/z, multiplied by (1 + 1/z)^order."""
    total = [0.0] * (order + 1)
    for power, factor in enumerate(polynomial):
        term = [factor * (2 / seconds) ** power]
        for binomial in [(1.0, -1.0)] * power + [(1.0, 1.0)] * (order - power):
            term = _times(term, binomial)
        total = [a + b for a, b in zip(total, term, strict=True)]
    return total


def _past(block: FunctionBlock, name: str, order: int) -> list[float]:
    return [block.real(f"~{name}{n}") for n in range(1, order + 1)]


def _remember(
    block: FunctionBlock, inputs: list[float], outputs: list[float], *, finite: bool, restart: bool
) -> None:
    """Store values for later calls, newest first; on an overflow, store nothing or restart the filter."""
    if finite:
        block.set(**{f"~x{n}": x for n, x in enumerate(inputs, start=1)})
        block.set(**{f"~y{n}": y for n, y in enumerate(outputs, start=1)})
    elif restart:
        block.set(**{"~y1": math.nan})


def _filtered(
    block: FunctionBlock,
    value: float,
    upper: Polynomial,
    lower: Polynomial,
    *,
    begin: bool = False,
    restart: bool = True,
) -> float:
    """Execute a transfer function; return Out.

    Args:
        upper: the numerator, a polynomial of s of at most the order of the denominator.
        lower: the denominator.
        begin: whether the filter starts, as in the first scan and with Initialize.
        restart: whether the filter restarts after a value that is not finite.
    """
    order = len(lower) - 1
    begin = begin or block.first or block.on("Initialize")
    if begin or not math.isfinite(value + block.real("~y1")):
        steady = value * upper[0] / lower[0]
        block.set(Out=steady)
        _remember(block, [value] * order, [steady] * order, finite=math.isfinite(value), restart=restart)
        return steady
    if block.delta_t <= 0:
        return block.real("Out")
    above, below = (_in_delays(polynomial, order, block.delta_t) for polynomial in (upper, lower))
    inputs = [value, *_past(block, "x", order)]
    outputs = _past(block, "y", order)
    out = sum(a * x for a, x in zip(above, inputs, strict=True))
    out = (out - sum(b * y for b, y in zip(below[1:], outputs, strict=True))) / below[0]
    block.set(Out=out)
    rounded = block.rounded(out)
    _remember(block, inputs[:-1], [out, *outputs[:-1]], finite=math.isfinite(rounded), restart=restart)
    return rounded


def _lead_lag(block: FunctionBlock) -> float:
    """Run one call of LDLG; return Out. An infinite Lead or Lag keeps the filter in its steady state."""
    value = block.real("In") * block.real("Gain") + block.real("Bias")
    lead = block.limited("Lead", 0.0, math.inf)
    lag = block.limited("Lag", block.delta_t / 2, math.inf)
    endless = not math.isfinite(lead + lag)
    return _filtered(block, value, (1.0, lead), (1.0, lag), begin=endless, restart=False)


def frequency(block: FunctionBlock, name: str) -> float:
    """Return a frequency, limited to the range that DeltaT allows."""
    if block.delta_t <= 0:
        return 1.0
    return block.limited(name, 1e-7 / block.delta_t, 0.7 * math.pi / block.delta_t)


def _order(block: FunctionBlock, orders: Sequence[int]) -> int:
    """Return Order; if it is invalid, note the fault and return the first allowed order."""
    order = int(block["Order"])
    return orders[0] if block.wrong(OrderInv=order not in orders) else order


def _filter_of_order(name: str, *orders: int) -> Callable[[FunctionBlock], float]:
    """Return the function of a filter with a frequency input; the first order replaces an invalid one.

    [help, LPF: Order]
    """

    def step(block: FunctionBlock) -> float:
        """Build the two polynomials for Order and the frequency; return Out."""
        order = _order(block, orders)
        w = frequency(block, name)
        quality = block.limited("QFactor", 0.5, 100.0) if name == "WNotch" else 0.0
        if name == "WNotch":
            upper, lower = [w * w, 0.0, 1.0], [w * w, w / quality, 1.0]
            if order == _MOST_ORDER:
                upper, lower = _times(upper, upper), _times(lower, lower)
        else:
            lower = [
                coefficient * w ** (order - power) for power, coefficient in enumerate(_BUTTERWORTH[order])
            ]
            upper = [lower[0]] if name == "WLag" else [0.0] * order + [1.0]
        return _filtered(block, block.real("In"), upper, lower)

    return step


_MOST_RATIO = {1: 40.0, 2: 10.0}
"""Highest WLag of LDL2 by order, as a multiple of WLead."""


def _second_lead_lag(block: FunctionBlock) -> float:
    """Run one call of LDL2, with WLag limited in proportion to WLead; return Out."""
    order = _order(block, (2, 1))
    lead, lag = (frequency(block, name) for name in ("WLead", "WLag"))
    limit = _MOST_RATIO[order] * lead
    if block.wrong(WLagRatioInv=lag > limit):
        lag = limit
    damping = block.limited("ZetaLead", 0.0, 4.0), block.limited("ZetaLag", 0.05, 4.0)
    upper, lower = (
        [1.0, 1 / w] if order == 1 else [1.0, 2 * zeta / w, 1 / (w * w)]
        for w, zeta in zip((lead, lag), damping, strict=True)
    )
    return _filtered(block, block.real("In"), upper, lower)


def _derive(block: FunctionBlock) -> float:
    """Compute Out = Gain (In - previous In) / DeltaT; with ByPass, Out = In."""
    value, previous_in = block.real("In"), block.real("~x1")
    out = block.real("Out")
    if block["ByPass"]:
        out = value
    elif block.first:
        out = 0.0
    elif block.delta_t > 0:
        out = block.real("Gain") * (value - previous_in) / block.delta_t
    if math.isfinite(value) and (block.first or block.delta_t > 0):
        block.set(**{"~x1": value})
    block.set(Out=out)
    return out


def _within_limits(block: FunctionBlock, out: float) -> float:
    """Set the alarms; return Out within its limits, or LowLimit if the limits are invalid."""
    low, high = block.real("LowLimit"), block.real("HighLimit")
    crossed = block.wrong(HighLowLimsInv=not low < high)
    block.set(HighAlarm=crossed or out >= high, LowAlarm=crossed or out <= low)
    return low if crossed else min(max(out, low), high)


def _integrate(block: FunctionBlock) -> float:
    """Compute Out = previous Out + IGain (In + previous In)/2 DeltaT, within its limits."""
    value, gain = block.real("In"), block.limited("IGain", 0.0, math.inf)
    starts = block.first or block.on("Initialize")
    previous_out, change = block.real("~exact"), 0.0
    if starts:
        previous_out = block.real("InitialValue")
    elif block.delta_t > 0:
        change = gain * (value + block.real("~x1")) / 2 * block.delta_t
    if block.forbids(change):
        change = 0.0
    out = _within_limits(block, previous_out + change)
    block.set(Out=out)
    if math.isfinite(out) and math.isfinite(value) and (starts or block.delta_t > 0):
        block.set(**{"~exact": out, "~x1": value})
    return out


def _delay(block: FunctionBlock) -> float:
    """Compute Out = In x Gain + Bias, with In delayed by Deadtime; the array is the buffer, newest first.

    Deadtime is rounded to a multiple of DeltaT. When the buffer grows, its oldest value is repeated. In the
    first scan, after an InFault, and with an invalid Deadtime, Out is In x Gain + Bias without delay, and
    this value fills the buffer.
    """
    (buffer,) = block.arrays
    value = block.real("In") * block.real("Gain") + block.real("Bias")
    faulted, was_faulted = block.on("InFault"), block.on("~faulted")
    block.set(**{"~faulted": faulted})
    if block.wrong(InFaulted=faulted):
        return block.real("Out")
    begin = block.first or was_faulted
    if block.delta_t <= 0 and not begin:
        return block.real("Out")
    deadtime, size = block.real("Deadtime"), len(buffer)
    invalid = not block.first and block.wrong(DeadtimeInv=not 0 <= deadtime <= size * block.delta_t)
    if begin or invalid:
        block.set(Out=value)
        stored = block.rounded(value)
        if math.isfinite(stored):
            for index in range(size):
                buffer[index] = stored
            block.set(**{"~held": size})
        return value
    return _delayed(block, buffer, value, math.floor(deadtime / block.delta_t + 0.5))


def _delayed(block: FunctionBlock, buffer: Elements, value: float, delay: int) -> float:
    """Shift the value into the buffer; return Out, the value from `delay` calls ago.

    A buffer that must grow first repeats its oldest value. A value that is not finite is not stored.
    """
    stored, out = block.rounded(value), block.real("Out")
    held = min(int(block["~held"]), delay)
    fill = out if math.isfinite(out) else stored
    oldest = buffer[held - 1] if held else fill
    if math.isfinite(stored):
        for index in range(held, delay):
            buffer[index] = oldest
        if delay > 1:
            buffer.put(1, buffer.take(0, delay - 1), delay - 1)
        if delay:
            buffer[0] = stored
        block.set(**{"~held": delay})
    block.set(Out=oldest if delay else value)
    return block.real("Out")


LDLG = block_row("LDLG", _lead_lag)
LPF = block_row("LPF", _filter_of_order("WLag", 1, 2, 3))
HPF = block_row("HPF", _filter_of_order("WLead", 1, 2, 3))
NTCH = block_row("NTCH", _filter_of_order("WNotch", 2, 4))
LDL2 = block_row("LDL2", _second_lead_lag)
DERV = block_row("DERV", _derive)
INTG = block_row("INTG", _integrate)
DEDT = block_row("DEDT", _delay)
