"""Registry of the monitors by name: tierod's own, and those of installed packages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tierod.core.plugins import Registry
from tierod.monitors.session import Monitor, Variant

_OWN = {
    "friction": "tierod.monitors.friction.definition:FRICTION",
    "hysteresis": "tierod.monitors.hysteresis.definition:HYSTERESIS",
    "sideslip": "tierod.monitors.sideslip.definition:SIDESLIP",
    "driver-torque": "tierod.monitors.driver_torque.definition:DRIVER_TORQUE",
    "motor-angle": "tierod.monitors.motor_angle.definition:MOTOR_ANGLE",
    "condition": "tierod.monitors.condition.definition:CONDITION",
}


def obstacle(monitor: Any) -> str:
    """Reason why an object, without its variants of other packages, cannot be run as a monitor, as a half-sentence."""
    if not isinstance(monitor, Monitor):
        kind = getattr(type(monitor), "__name__", "")
        return f"is of the type '{kind}'; expected a tierod.Monitor with name, required signals, rate and variants"
    if not (names := getattr(monitor.variants, "own", monitor.variants)):
        return "has no variant; give it variants={'name': tierod.Variant(...)}"
    for name, variant in ((each, monitor.variants[each]) for each in names):
        if not isinstance(variant, Variant) or not callable(variant.open):
            return f"has a variant '{name}' that lacks 'open', which builds its session; make it a tierod.Variant"
        if variant.name != name:
            return f"has a variant '{variant.name}' under the name '{name}'; use one name"
    if monitor.default is not None and monitor.default not in monitor.variants:
        return f"has no variant '{monitor.default}', which is its default; it has {', '.join(monitor.variants)}"
    if not monitor.rate > 0.0 or not monitor.maximum_age > 0.0:
        return f"needs a positive rate and maximum age, not {monitor.rate} Hz and {monitor.maximum_age} s"
    return ""


def _registered_obstacle(name: str, monitor: Any) -> str:
    """Reason why an object cannot be registered as a monitor under a name; "" if it can."""
    if not (why := obstacle(monitor)) and monitor.name != name:
        return f"calls itself '{monitor.name}'; register it under that name"
    return why


def variants_with_plugins(monitor: str, own: Mapping[str, str]) -> Registry[Variant]:
    """Variants of a monitor by name, with those that packages register in the group "tierod.variants.MONITOR"."""
    return Registry(f"tierod.variants.{monitor.replace('-', '_')}", "variant", own, _variant_obstacle)


def _variant_obstacle(name: str, variant: Any) -> str:
    """Reason why an object cannot be registered as a variant under a name; "" if it can."""
    if not isinstance(variant, Variant) or not callable(variant.open):
        return "is no tierod.Variant with 'open', which builds its session"
    return "" if variant.name == name else f"calls itself '{variant.name}'; register it under that name"


MONITORS: Registry[Monitor] = Registry("tierod.monitors", "monitor", _OWN, _registered_obstacle)
"""Monitors by name, as given on the command line; a monitor is imported only when it is used."""
