"""The motions of a 3601: moves, blend moves, homing and the encoder follower."""
