"""GSV as Python code: `Spec.fetch` returns the bytes of an attribute, and the written lines store them."""

from __future__ import annotations

from ..model.operands import Group, Place
from ..model.types import Structure, size_of
from .files import ElementText, byte_end, has_elements
from .rungs import RungWriter


def write_gsv(
    rungs: RungWriter, _kind: str, instance: str | Place, _name: str, target: Place | Group
) -> None:
    """Write GSV whose destination is a number, numbers in a list or a view, or a structure in bytes."""
    values, line = rungs.values, rungs.writer.line
    fetched = f"fetched({values.site})"
    if isinstance(instance, Place) or (isinstance(target, Place) and target.bit is not None):
        rungs.interpret()
    elif isinstance(target.type, Structure):
        _write_bytes(rungs, target, fetched)
    elif has_elements(rungs, target) and target.type.is_integer:
        data = values.keep(fetched)
        elements = ElementText(rungs, target)
        row_text = f"{elements.row}, {elements.at}, {elements.left}"
        line(f"store_bytes({row_text}, {target.type.code!r}, {size_of(target.type)}, {data})")
    elif isinstance(target, Place) and target.type.is_integer and not rungs.writer.mask(target.leaf):
        code, size = target.type.code, size_of(target.type)
        values.assign(target, f"first_of({fetched}, {code!r}, {size}, {values.read(target)})")
    else:
        rungs.interpret()


def _write_bytes(rungs: RungWriter, target: Place | Group, fetched: str) -> None:
    """Write GSV for a structure in bytes, which receives at most its size; interpret other destinations."""
    spot = rungs.writer.layout.byte_spot(target.path) if isinstance(target, Group) else None
    if spot is None:
        rungs.interpret()
        return
    data = rungs.values.keep(fetched)
    end = byte_end(rungs, target)
    assert end is not None
    count = rungs.values.keep(f"min(len({data}), {end.left})")
    offset = rungs.values.keep(end.at)
    rungs.writer.line(f"{end.tag}.B[{offset}:{offset} + {count}] = {data}[:{count}]")
