"""State estimators: blocks that compute estimates with variances from a discrete model and its noise."""
