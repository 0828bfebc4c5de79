"""Simulated networked drives of AMCI: a module in a slot, or a unit behind a server or an adapter.

| file | contents |
|---|---|
| `drive` | a unit: time, inputs, the image |
| `layer` | modes, edges, refusals, latched bits |
| `motions` | moves, jogs, home search, assembled moves |
| `nonvolatile` | what the flash keeps |
| `registers` | the Modbus registers of a stack, as PDUs |
| `conditions` | what is around a unit, as text |
| `options` | readings that can be switched |
| `record` | the records for the registry |
"""
