"""What all monitors share: running over a recording, checks of the inputs, judged time, contradictions, baseline."""
