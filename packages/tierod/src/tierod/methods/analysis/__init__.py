"""Analysis of models and filter runs: observability, model reduction, frequency response, consistency."""
