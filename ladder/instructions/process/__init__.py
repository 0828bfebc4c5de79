"""Process control, alarms and safety."""
