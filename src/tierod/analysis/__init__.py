"""Analysis of models and of finished runs: observability, consistency."""
