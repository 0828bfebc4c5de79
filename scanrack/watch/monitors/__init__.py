"""The page's view and questions: the monitors of a session and of a recording."""
