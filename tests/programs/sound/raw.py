'''A function with module state and helper functions, raw words only.'''

from scanrack import Idle

PARAMETERS = [0, 0, 2, 500, 4, 0, 50, 50]
CONFIGURE = [0x8434, 0x0034, 0, 500, 0, 0, 0, 0]
state = {"step": 0, "count": 0, "since": 0}


def send(outputs, words):
    for index, word in enumerate(words):
        outputs[index] = word


def elapsed_ms(scan):
    return (scan.now_ns - state["since"]) // 1_000_000


def go(scan, step):
    state["step"], state["since"] = step, scan.now_ns


def logic(scan):
    card = scan.slot[1]
    flags = card.inputs[0]
    button = scan.slot[2].inputs.bit(0, 3)
    if scan.first or state["step"] == 0:
        send(card.outputs, CONFIGURE)
        if flags & 0x8000 and not flags & 0x2000:
            go(scan, 1)
    elif state["step"] == 1:
        card.outputs.load(Idle().to_image())
        if not flags & 0x8000 and elapsed_ms(scan) > 20:
            go(scan, 2)
    elif state["step"] == 2 and button:
        send(card.outputs, PARAMETERS)
        card.outputs.set_bit(0, 1, True)
        go(scan, 3)
    elif state["step"] == 3 and flags & 0x0003:
        card.outputs.clear()
        go(scan, 4)
    elif state["step"] == 4 and flags & 0x0080:
        state["count"] += 1
        go(scan, 2)
    scan.slot[3].outputs[0] = state["count"] & 0xFF
