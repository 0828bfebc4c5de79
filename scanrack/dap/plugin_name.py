"""The name under which pytest's plugin manager has the debugger of a test run.

The debugger is called with each bench when the bench is opened.
"""

DEBUGGER = "scanrack-debugger"
