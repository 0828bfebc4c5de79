#!/usr/bin/env bash
# what: pycomm3 treats a partial answer to Read Tag as an error, so it can't read a long array from a server with short answers
# date: 2026-11-30
# meets: anyone who reads arrays with pycomm3 from a server that is not Rockwell's, or through one
# expected: 240 values, since status 06h says that more data follows and pylogix and the service's fragmented form fetch it
# behavior:
#   On a connection of 4,000 bytes pycomm3 asks for 480 bytes in one Read Tag. The server sends 478 of them with status 06h;
#   pycomm3 returns "Insufficient Packet Space" and no value, where pylogix continues with Read Tag Fragmented.
# product: Its EtherNet/IP server fills the answer up to the connection's size: [HMI](hmi.md#what-clients-see)
# output:
#   pycomm3: 239 elements: 239 values, no error
#   pycomm3: 240 elements: no value, Insufficient Packet Space
#   pylogix: 240 elements: 240 values, Success
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install cm-ethernetip==0.1.0 pycomm3==1.2.16 pylogix==1.1.6
observe python - <<'PY'
import asyncio

from ethernetip.cip.identity_info import IdentityInfo
from ethernetip.logix import data_types
from ethernetip.logix.logix_dispatcher import LogixDispatcher
from ethernetip.logix.tag_database import TagDatabase
from ethernetip.protocol.eip_adapter import EipAdapter
from pycomm3 import LogixDriver
from pylogix import PLC

PORT = 18106


def read():
    with LogixDriver(f"127.0.0.1:{PORT}", init_program_tags=False) as plc:
        for count in (239, 240):
            answer = plc.read(f"counts{{{count}}}")
            values = f"{len(answer.value)} values" if answer.value else "no value"
            print(f"pycomm3: {count} elements: {values}, {answer.error or 'no error'}")
    with PLC("127.0.0.1", port=PORT, timeout=10) as plc:
        answer = plc.Read("counts[0]", 240)
        print(f"pylogix: 240 elements: {len(answer.Value)} values, {answer.Status}")


async def main():
    tags, identity = TagDatabase(), IdentityInfo(product_name="Sample")
    tags.add_tag("counts", data_types.INT, element_count=600)
    await EipAdapter(LogixDispatcher(tags, identity), identity).listen("127.0.0.1", PORT)
    await asyncio.to_thread(read)


asyncio.run(main())
PY
