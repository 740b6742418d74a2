"""Hardware profiles as plain data and as text, with the source of every number."""

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from ftcfa.hardware.profiles import Profile
from ftcfa.report.records import versions
from ftcfa.report.terminal import print_facts, print_line

UNITS = {
    "period": "s",
    "sensors.resolution": "rad",
    "sensors.latency": "s",
    "actuators.rate_limit": "N m/s",
    "actuators.effort_limit": "N m",
    "actuators.bandwidth": "Hz",
    "noise_density": "m/s^2/sqrt(Hz)",
    "bias": "m/s^2",
    "range": "m/s^2",
    "bandwidth": "Hz",
    "delay": "s",
    "rate": "Hz",
}
"""Units of the numbers of profiles."""


def profiles_record(profiles: Mapping[str, Profile]) -> dict[str, Any]:
    """Some profiles as plain data."""
    return {
        "profiles": [
            {
                "name": profile.name,
                "description": profile.description,
                "joints": profile.joints,
                "note": profile.note,
                "numbers": {
                    name: {
                        "value": number.value,
                        "unit": UNITS.get(name, ""),
                        "source": number.source,
                        "verified": number.verified,
                    }
                    for name, number in profile.numbers.items()
                },
            }
            for profile in profiles.values()
        ],
        "versions": versions("ftcfa"),
    }


def print_profiles(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `profiles_record`."""
    for k, profile in enumerate(record["profiles"]):
        if k:
            console.print()
        print_line(f"{profile['name']}: {profile['description']}", console, "bold")
        if profile["note"]:
            print_line(profile["note"], console)
        facts = [
            (name, f"{_shown(number['value'])} {number['unit']}".strip() + f"; {number['source']}"
             f" ({number['verified']})")
            for name, number in profile["numbers"].items()
        ]  # fmt: skip
        if profile["joints"]:
            facts.insert(0, ("joints", str(profile["joints"])))
        if facts:
            print_facts(facts, console)


def _shown(value: Any) -> str:
    """A number, one for each joint, or a part by its type and numbers."""
    if isinstance(value, Mapping):
        rest = ", ".join(f"{key}={each:g}" for key, each in value.items() if key != "type")
        return f"{value['type']}({rest})"
    return ", ".join(f"{each:g}" for each in (value if isinstance(value, list) else [value]))
