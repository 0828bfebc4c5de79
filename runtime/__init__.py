"""What happens in time: the scan loop, the rack, motion, the machine, the modules, the commands.

Time is an integer number of nanoseconds since power-up, everywhere. Nothing in
this room but `pace` knows the clock on the wall, and nothing but `cli` knows
the rooms of programs and recordings.
"""
