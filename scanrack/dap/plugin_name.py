"""The name of a test run's debugger in pytest's plugin manager.

The debugger is called with each bench when the bench is opened.
"""

DEBUGGER = "scanrack-debugger"
