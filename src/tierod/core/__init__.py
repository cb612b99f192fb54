"""What everything speaks: blocks and their graph, fields, units, signals, recordings, findings, errors, files."""
