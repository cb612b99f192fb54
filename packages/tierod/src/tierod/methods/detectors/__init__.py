"""Detectors: blocks that turn a residual into a statistic and a decision, and the design of their thresholds."""

from tierod.methods.detectors.control_charts import Condition, Cusum, Debounce, Detector, HeldThreshold, Value

__all__ = ["Condition", "Cusum", "Debounce", "Detector", "HeldThreshold", "Value"]
