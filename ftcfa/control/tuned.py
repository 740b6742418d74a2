"""The paper's law with the gains that were tuned for an arm of the catalogue: robots/gains.toml.

`scripts/tune_arms.py` writes the file: for each arm, environment and hardware the gains, the seed,
the date, and what they do beside the paper's gains on fresh paths.
"""

import tomllib
from collections.abc import Mapping
from functools import cache
from typing import Any

from ftcfa.checks import known_name
from ftcfa.control.filters import ImplicitFilter
from ftcfa.control.ftcf import FTCF
from ftcfa.control.gains import Gains
from ftcfa.model.arm import Arm
from ftcfa.model.urdf.catalogue import robots_folder

FILE = "gains.toml"
GAINS, FILTER = "controller.gains.", "controller.filter."
"""What the names of gains and of the filter's gains begin with."""


@cache
def tuned_gains() -> Mapping[str, Any]:
    """The content of robots/gains.toml: arm to environment to hardware to what was found."""
    return tomllib.loads((robots_folder() / FILE).read_text())


def tuned_law(arm: Arm, environment: str, hardware: str = "ideal") -> FTCF:
    """The paper's law, its bias compensated, with the gains tuned for an arm of the catalogue.

    Args:
        arm: The arm as the controller knows it; its name says which gains it gets.
        environment: ``"still"``, ``"truck"`` (MIL-STD-810G, a highway truck's floor) or ``"ship"``
            (shaped noise about 0.2 Hz, 1 m/s^2 rms in each axis, an example).
        hardware: ``"ideal"``, or the profile that the gains were tuned for; the period of the
            controller, which the file states, has to be the loop's.

    Raises:
        UnknownNameError: If there are no gains for it; it lists what there is.
    """
    known_name("tuned gains of the arm", arm.name, tuned_gains())
    of_arm = tuned_gains()[arm.name]
    known_name(f"tuned gains of {arm.name}: environment", environment, of_arm)
    known_name(f"tuned gains of {arm.name}, {environment}: hardware", hardware, of_arm[environment])
    found = of_arm[environment][hardware]["gains"]

    def under(prefix: str) -> dict[str, Any]:
        return {k.removeprefix(prefix): v for k, v in found.items() if k.startswith(prefix)}

    return FTCF(arm, Gains(**under(GAINS)), ImplicitFilter(**under(FILTER)), "bias")
