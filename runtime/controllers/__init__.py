"""Simulated controllers: what is at the far end of a line.

Each turns bytes into motion of a simulated machine. They know lines, machines and kinematics.
"""
