"""The name of the debugger of a test run in pytest's plugin manager.

It is called with each bench when the bench is opened.
"""

DEBUGGER = "scanrack-debugger"
