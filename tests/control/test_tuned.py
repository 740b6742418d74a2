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


def test_nearly_all_are_better_than_the_paper_s():
    """Error of the worst 5 %, ideal hardware; a heavy tail may fool the tuner here and there."""
    better = []
    for arm, environment, hardware in CASES:
        found = tuned_gains()[arm][environment][hardware]
        if hardware == "ideal" and found["answer"] == "yes" and len(found["error_paper"]) == 2:
            better.append(found["error_tuned"][1] <= 1.02 * found["error_paper"][1])
    assert len(better) > 30
    assert sum(better) >= 0.95 * len(better)


def test_what_there_is_not_is_refused():
    arm = load_arm("panda")
    with pytest.raises(UnknownNameError, match="tuned gains of panda: environment 'trunk'"):
        tuned_law(arm, "trunk")
    with pytest.raises(UnknownNameError, match="tuned gains of panda, truck: hardware 'fr4'"):
        tuned_law(arm, "truck", "fr4")
