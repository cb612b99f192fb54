"""Analysis of models and of finished runs: observability, reduction, frequency response, consistency."""
