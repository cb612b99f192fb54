"""Schema of a vehicle file, as pydantic checks it: strict types, no unknown key."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, StringConstraints

Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class ParameterEntry(_Strict):
    """One ``[parameters.NAME]`` table: value, its unit, how well it is known, and from where."""

    value: FiniteFloat
    unit: str
    standard_deviation: Annotated[FiniteFloat, Field(ge=0.0)] | None = None
    source: Text


class ChannelsEntry(_Strict):
    """The ``[channels]`` table: files beside the vehicle file on how to read its bus."""

    map: Text | None = None
    dbc: Text | None = None


Threshold = FiniteFloat | Text | dict[str, FiniteFloat]
"""A number, a word on where it comes from, or numbers by name."""


class VehicleFile(_Strict):
    """One vehicle file as a whole."""

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
