"""The PMC006x3s as data: frames, instructions, status bits, user programs.

Brackets contain sections of the manual V0.1.0 (2023-09-19).
"""
