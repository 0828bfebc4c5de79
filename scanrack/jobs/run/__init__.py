"""From a specification to a rack and a CPU; a job, run and recorded."""
