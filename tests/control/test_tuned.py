"""The gains that are shipped: robots/gains.toml."""

import pytest

from ftcfa import FTCF, load_arm, profiles, tuned_gains, tuned_law
from ftcfa.errors import UnknownNameError
from ftcfa.model.urdf.catalogue import catalogue

CASES = [
    (arm, environment, hardware)
    for arm, environments in tuned_gains().items()
    for environment, found in environments.items()
    for hardware in found
]


def test_every_arm_of_the_catalogue_has_them_for_every_environment():
    for arm in catalogue():
        assert set(tuned_gains()[arm]) == {"still", "truck", "ship"}


@pytest.mark.parametrize(("arm", "environment", "hardware"), CASES)
def test_they_make_a_law(arm, environment, hardware):
    law = tuned_law(load_arm(arm), environment, hardware)
    assert isinstance(law, FTCF)
    assert law.compensation == "bias"
    found = tuned_gains()[arm][environment][hardware]
    assert law.gains.c1 == found["gains"]["controller.gains.c1"]
    assert law.filter.r1 == found["gains"]["controller.filter.r1"]
    assert hardware in profiles()
    if found["answer"] == "yes" and found["error_paper"] and found["error_tuned"]:
        assert found["error_tuned"][-1] <= found["error_paper"][-1] * 1.1


def test_what_there_is_not_is_refused():
    arm = load_arm("panda")
    with pytest.raises(UnknownNameError, match="tuned gains of panda: environment 'trunk'"):
        tuned_law(arm, "trunk")
    with pytest.raises(UnknownNameError, match="tuned gains of panda, truck: hardware 'fr4'"):
        tuned_law(arm, "truck", "fr4")
