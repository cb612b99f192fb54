"""Common parts of all monitors: run over a recording, checks of the inputs, judged time, decisions, baseline."""
