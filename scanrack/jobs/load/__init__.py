"""From the path of a rack to a job: specification, logic, and the files they come from."""
