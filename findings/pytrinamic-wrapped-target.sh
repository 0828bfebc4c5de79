#!/usr/bin/env bash
# what: PyTrinamic sends a target position beyond 32 bits without its upper bits, so the motor moves somewhere else
# date: 2026-11-30
# meets: axes that run endlessly in one direction, whose positions are counted in a Python integer
# expected: an error for a position that a TMCL module cannot have
# behavior:
#   The value of a request is masked with FFFFFFFFh. A move to 4,294,967,396 arrives as 100, and one to -2,147,483,649
#   as +2,147,483,647, so the motor turns the other way. The module confirms both.
# product: A position out of range raises ValueError before anything is sent: [line clients](line-clients.md)
# output:
#   move_to 100: the module receives 100
#   move_to -100: the module receives -100
#   move_to 2147483648: the module receives -2147483648
#   move_to -2147483649: the module receives 2147483647
#   move_to 4294967396: the module receives 100
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install PyTrinamic==0.2.26
observe python - <<'PY'
import struct

from pytrinamic.connections.tmcl_interface import TmclInterface


class Module(TmclInterface):
    """A TMCL module that confirms each command with status 100."""

    def _send(self, host_id, module_id, data):
        self.request = struct.unpack(">BBBBiB", data)

    def _recv(self, host_id, module_id):
        reply = struct.pack(">BBBBi", host_id, module_id, 100, self.request[1], self.request[4])
        return reply + bytes([sum(reply) & 0xFF])


module = Module()
for target in (100, -100, 2**31, -(2**31) - 1, 2**32 + 100):
    module.move_to(0, target)
    print(f"move_to {target}: the module receives {module.request[4]}")
PY
