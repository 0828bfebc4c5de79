"""The format of a recording: records, schemas, layouts, topics."""
