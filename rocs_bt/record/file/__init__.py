"""Files of a recording: header, events, and summary; writing and reading."""
