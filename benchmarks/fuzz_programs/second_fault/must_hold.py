from scanrack import always


@always
def one_command(now):
    """Never two motion commands at once."""
    return now.slot[1].motions <= 1
