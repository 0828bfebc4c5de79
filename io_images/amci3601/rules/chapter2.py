"""Chapter 2: calculating move profiles."""

from __future__ import annotations

from .rule import Rule

# One row of the manual is one row here; the formatter would spread each over ten lines.
# fmt: off

ROWS: tuple[Rule, ...] = (
    Rule("PRO-01", "chapter 2, Calculating Move Profiles",
         "A trapezoidal profile jumps to the starting speed, accelerates to the programmed speed, keeps it, "
         "decelerates to the starting speed and stops."),
    Rule("PRO-03", "chapter 2, Calculating Move Profiles",
         "The time to accelerate is the difference of programmed and starting speed divided by the "
         "acceleration in steps/s/s."),
    Rule("PRO-04", "chapter 2, Calculating Move Profiles",
         "The distance to accelerate is the time to accelerate multiplied by the mean of starting and "
         "programmed speed."),
    Rule("PRO-05", "chapter 2, Calculating Move Profiles",
         "A triangular S-curve takes twice the time of constant acceleration.",
         reading=("A-79",)),
    Rule("PRO-06", "chapter 2, Calculating Move Profiles",
         "A trapezoidal S-curve takes 4/3 of the time of constant acceleration.",
         reading=("A-79",)),
    Rule("PRO-07", "chapter 2, Calculation Notes 1",
         "Acceleration and deceleration words are in steps/ms/s; multiplied by 1000 they are the steps/s/s "
         "of the formulas."),
    Rule("PRO-02", "chapter 2, Calculation Notes 2 and 3",
         "A move too short for both of its ramps runs a triangular profile: it decelerates before it has "
         "reached the programmed speed."),
    Rule("PRO-08", "chapter 2, Calculation Notes 3",
         "The steps at constant speed are what the two ramps leave of the move; the times of ramps and "
         "constant speed add up to the time of the move."),
    Rule("PRO-09", "chapter 2, Starting Speed",
         "The first and the last pulse of a move are at the starting speed; a programmed speed equal to it "
         "gives a move without ramps."),
)
# fmt: on
