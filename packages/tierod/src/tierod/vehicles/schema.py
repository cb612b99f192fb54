"""Schema of a vehicle file for pydantic, with strict types and without unknown keys."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, StringConstraints

Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class ParameterEntry(_Strict):
    """One ``[parameters.NAME]`` table: value, unit, standard deviation and source."""

    value: FiniteFloat
    unit: str
    standard_deviation: Annotated[FiniteFloat, Field(ge=0.0)] | None = None
    source: Text


class ChannelsEntry(_Strict):
    """The ``[channels]`` table: files that define how recordings of the vehicle are read."""

    map: Text | None = None
    dbc: Text | None = None


Threshold = FiniteFloat | Text | dict[str, FiniteFloat]
"""A number, a text on its origin, or numbers by name."""


class VehicleFile(_Strict):
    """The whole vehicle file."""

    name: Text
    description: Text
    source: Text
    good_for: Annotated[list[Text], Field(min_length=1)]
    not_good_for: Annotated[list[Text], Field(min_length=1)]
    torque_unit: Literal["N*m", "count"]
    monitor: Text | None = None
    parameters: dict[str, ParameterEntry]
    channels: ChannelsEntry = ChannelsEntry()
    thresholds: dict[str, dict[str, Threshold]] = {}
