"""Spelling of numbers, types and functions in C, for one precision and the name prefix of one monitor."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

Precision = Literal["single", "double"]

_LITERAL = re.compile(r"\bR\(([0-9.e+-]+)\)")
_FUNCTION = re.compile(r"\bM\((\w+)\)")
_OWN = re.compile(r"\btierod_(\w+)\(")


@dataclass(frozen=True)
class Spelling:
    """Names and literals of one export.

    Args:
        prefix: of all names ("tierod_friction")
        fused: whether multiply-add is always rounded once, even if the target has no instruction for it
    """

    prefix: str
    precision: Precision
    fused: bool = False

    @property
    def real(self) -> str:
        """C type of all numbers."""
        return f"{self.prefix}_real_t"

    @property
    def suffix(self) -> str:
        """Suffix of literals and of C library functions."""
        return "f" if self.precision == "single" else ""

    def number(self, value: float) -> str:
        """C literal of the nearest number in this precision; infinity beyond its range."""
        if math.isnan(value):
            return f"(({self.real})NAN)"
        with np.errstate(over="ignore"):
            rounded = float(np.float32(value)) if self.precision == "single" else value
        if math.isinf(rounded):
            return f"(({self.real})INFINITY)" if value > 0.0 else f"(-({self.real})INFINITY)"
        text = repr(abs(value if rounded else 0.0)) + self.suffix
        return text if math.copysign(1.0, value) > 0.0 else f"(-{text})"

    def spelt(self, text: str) -> str:
        """A line of the kernels' printer with its macros replaced."""
        text = _OWN.sub(lambda found: f"{self.prefix}_{found[1]}(", self.literals(text))
        return text.replace("(real)", f"({self.real})").replace("const real ", f"const {self.real} ")

    def literals(self, text: str) -> str:
        """A text with literals and C library functions spelt in this precision."""
        text = _LITERAL.sub(lambda found: found[1] + self.suffix, text)
        return _FUNCTION.sub(lambda found: found[1] + self.suffix, text)
