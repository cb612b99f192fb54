"""The bank of filters: one filter for every hypothesis, how they are weighed, and what the judge says."""
