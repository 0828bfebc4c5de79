"""Simulated AMCI networked drives, used as a module in a slot or as a unit with a server or an adapter.

| file | contents |
|---|---|
| `drive` | a unit: time, inputs, the image |
| `layer` | modes, edges, refusals, latched bits |
| `motions` | moves, jogs, home search, assembled moves |
| `nonvolatile` | content of the flash |
| `registers` | the Modbus registers of a stack, as PDUs |
| `conditions` | the environment of a unit, as text |
| `drive_options` | interpretations that can be switched |
| `record` | the records for the registry |
"""
