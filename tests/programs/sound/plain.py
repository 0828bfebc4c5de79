counts = [0] * 4
total = 0


def logic(scan):
    global total
    inputs = scan.slot[2].inputs
    lamp = scan.slot[3].outputs
    for bit in range(4):
        if inputs.bit(0, bit):
            counts[bit] += 1
            total += 1
    if scan.first:
        lamp[0] = 0
    elif total % 2:
        lamp[0] = lamp[0] | 1
    else:
        lamp[0] = lamp[0] & ~1
    lamp.set_bit(0, 1, any(count > 10 for count in counts))
