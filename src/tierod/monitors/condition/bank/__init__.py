"""The bank of filters: one filter for every hypothesis, their weights, and the outputs of the judge."""
