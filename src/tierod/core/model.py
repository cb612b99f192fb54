"""What a model is: equations without memory.

A model is a class without state of its own: `State`, `Input`, `Output` are NamedTuples, `Parameters` a frozen
dataclass, and its two functions are pure. Noise belongs to the estimator that uses the model, not to the model.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class Model(Protocol):
    """Continuous equations x' = derivative(x, u, p), y = output(x, u, p)."""

    State: type
    Input: type
    Output: type
    Parameters: type

    @staticmethod
    def derivative(x: Any, u: Any, p: Any) -> Any:
        """Time derivative of the state."""

    @staticmethod
    def output(x: Any, u: Any, p: Any) -> Any:
        """What is measured."""


@runtime_checkable
class DiscreteModel(Protocol):
    """Sampled equations x+ = transition(x, u, p), y = output(x, u, p)."""

    State: type
    Input: type
    Output: type
    Parameters: type

    @staticmethod
    def transition(x: Any, u: Any, p: Any) -> Any:
        """The state one sample on."""

    @staticmethod
    def output(x: Any, u: Any, p: Any) -> Any:
        """What is measured."""
