"""An imaginary 3602: twice a 3601's speed and rates, and an error of its drive in word 1, with its rule."""

from dataclasses import replace

from scanrack.modules import RULES, WORDS_3601, BitPlace, Limits, Rule, stepper

DRIVE_ERROR = BitPlace("I", 1, 11)
FAST = Rule("DRV-01", "imaginary", "An S curve is used above 1,500,000 steps/s.", sets=1 << 16 + 11)

RECORD = stepper(
    replace(
        WORDS_3601,
        message="Amci3602",
        groups={
            **WORDS_3601.groups,
            "status": {**WORDS_3601.groups["status"], "DRIVE_ERROR": DRIVE_ERROR},
        },
        errors=(*WORDS_3601.errors, "DRIVE_ERROR"),
        limits=Limits(speed=2_000_000, rate=4_000),
        rules={**RULES, FAST.id: FAST},
        further_refusals=((FAST.id, lambda words, move: words[1] & 1 and (move.speed or 0) > 1_500_000),),
    )
)
