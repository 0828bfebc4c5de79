CONFIGURATION = [-31684, 60, 0, 500, 0, 0, 0, 0]
PARAMETERS = [0, 5, 0, 20, 20]  # LSW of the target, speed, rates
# ms of a cycle, command bit, thousands of the target
STEPS = [
    (0, 512, 0),  # Preset Position
    (200, 0, 0),
    (400, 2, 4),  # Relative Move of 4,000
    (1900, 0, 4),
    (2100, 2, -3),
    (2500, 16, -3),  # Immediate Stop, in its acceleration
    (2700, 0, -3),
    (3000, 1, 2),  # Absolute Move without a valid position: refused
    (3200, 0, 2),
    (3400, 2048, 0),  # Reset Errors
    (3600, 0, 0),
]


def logic(scan):
    at = (2 * scan.number - 100) % 4000
    command, target = [(bit, target) for ms, bit, target in STEPS if ms <= at][-1]
    words = [command, 0, target, *PARAMETERS]
    if command in (512, 16, 2048):
        words = [command, 0, 0, 0, 0, 0, 0, 0]
    if scan.number < 50:
        words = CONFIGURATION
    for number, word in enumerate(words):
        scan.slot[1].outputs[number] = word
