"""Motions of the 3601: moves, blends, homing, the follower."""
