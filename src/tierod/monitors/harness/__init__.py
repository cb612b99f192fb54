"""Common parts of all monitors: running over a recording, checks of inputs, judged time, contradictions, baseline."""
