"""Keywords of motion instructions as rungs print them [MOTION-RM002].

A number is the position of a word in its list, counting from 0: `MAS(Axis,Stop,2,...)` stops a Move.
"""

from __future__ import annotations

STOP_TYPES = (
    *("All", "Jog", "Move", "Gear", "Home", "Tune", "Test", "Time Cam", "Position Cam"),
    *("Master Offset Move", "Direct Control"),
)
NO_YES = ("No", "Yes")
DISABLED_ENABLED = ("Disabled", "Enabled")
SPEED_UNITS = ("Units per sec", "% of Maximum", "Seconds", "Units per MasterUnit", "Master Units")
RATE_UNITS = ("Units per sec2", "% of Maximum", "Seconds", "Units per MasterUnit2", "Master Units")
JERK_UNITS = ("Units per sec3", "% of Maximum", "% of Time", "Units per MasterUnit3", "Master Units")
PROFILES = ("Trapezoidal", "S-Curve", "Time Driven")
MERGE_SPEEDS = ("Programmed", "Current")
CHANGED_MOTION = ("Jog", "Move")
REDEFINITIONS = ("Absolute", "Relative")
POSITIONS = ("Actual", "Command")

LISTS = (
    *(STOP_TYPES, NO_YES, DISABLED_ENABLED, SPEED_UNITS, RATE_UNITS, JERK_UNITS, PROFILES, MERGE_SPEEDS),
    *(CHANGED_MOTION, REDEFINITIONS, POSITIONS),
    (
        "None",
        "Immediate Forward Only",
        "Immediate Reverse Only",
        "Position Forward Only",
        "Position Reverse Only",
    ),
    ("Same", "Opposite", "Reverse", "Unchanged"),
    ("Real", "Fraction", "Fraction_slave_master_counts"),
    ("Once", "Continuous", "Persistent"),
    ("Immediate", "Pending", "Forward Only", "Reverse Only", "Bi-directional", "Bidirectional"),
    ("Forward", "Reverse", "CW", "CCW", "Shortest", "Positive", "Negative"),
    ("Positive Edge", "Negative Edge", "Positive_Edge", "Negative_Edge"),
    ("Programmed", "Fast Stop", "Fast Disable", "Fast Shutdown", "Hard Disable", "Hard Shutdown"),
    ("Coordinated Move", "Coordinated Motion", "Coordinated Transform", "All Motion"),
    ("Volts", "Percent", "%", "Units", "RPM", "Per Minute", "Units per min", "Rev per min"),
    (
        "Time Driven Mode",
        "Master Driven Mode",
        "Active Motion",
        "Pending Motion",
        "Time Driven",
        "Master Driven",
    ),
    ("Specific", "Motor", "Marker", "Commutation", "Feedback", "Motor/Feedback", "Encoder"),
    ("Absolute Move", "Incremental Move", "Via", "Center", "Radius", "Center Incremental"),
    ("CW Full", "CCW Full", "Inverse", "Module", "Axis"),
    ("Master Axis", "Slave Axis", "Position", "Torque", "Velocity", "Acceleration"),
)
