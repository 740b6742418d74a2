"""Drawn robots are possible robots, spread as they say they are, and belong to (seed, path)."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from ftcfa import Arm, ParameterError, ShapeError, Uncertainty, UnknownNameError, load_arm
from ftcfa.arrays import Array
from ftcfa.model.urdf.catalogue import catalogue
from tests.model.texts import BASE, ELBOW, SHOULDER, TWO_JOINTS, link, robot

ROUNDING = 1e-12
"""Relative to the largest entry."""
DRAWS = 10_000
CONFIDENCE = 1 - 1e-6
KS_SIGNIFICANCE = 1e-6
"""A right distribution fails a Kolmogorov-Smirnov test one time in a million."""
SIGMAS = 5.0
"""Correlations lie within 5 standard errors: right ones fail one time in 1.7 million."""
PANDA = load_arm("panda")
XARM = load_arm("xarm7")

WIDE = {
    "log-normal": Uncertainty(mass=0.5, centre=0.05, shape=0.5),
    "bounded": Uncertainty(mass=0.5, centre=0.05, shape=0.5, distribution="bounded"),
    "log-normal, strain 2": Uncertainty(shape=2.0),
    "bounded, strain 2": Uncertainty(shape=2.0, distribution="bounded"),
    "all at their largest": Uncertainty(mass=2.0, centre=2.0, shape=2.0, payload=(0.0, 1e3)),
}


@pytest.fixture
def two_joints(urdf: Callable[..., Path]) -> Arm:
    """Two bodies of 1 kg at (0.1, 0, 0.2), each a ball: rotational inertia 0.1 kg m^2."""
    return load_arm(str(urdf(TWO_JOINTS)))


def mass_and_centre(inertias: Array) -> tuple[Array, Array]:
    return inertias[..., 0], inertias[..., 1:4] / inertias[..., :1]


def central_inertia(inertias: Array) -> Array:
    """Rotational inertia about the centre of mass, by the parallel axis theorem."""
    m, c = mass_and_centre(inertias)
    xx, xy, yy, xz, yz, zz = np.moveaxis(inertias[..., 4:], -1, 0)
    about_origin = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], -1).reshape(*m.shape, 3, 3)
    square = np.sum(c**2, axis=-1)[..., None, None] * np.eye(3) - c[..., None] * c[..., None, :]
    return about_origin - m[..., None, None] * square


def second_moments(inertias: Array) -> Array:
    """Integral of x x^T dm about the centre of mass: tr(I)/2 1 - I."""
    I = central_inertia(inertias)  # noqa: E741 (the field's letter)
    return np.trace(I, axis1=-2, axis2=-1)[..., None, None] / 2 * np.eye(3) - I


def logarithm(S: Array) -> Array:
    """Logarithm of symmetric matrices, shape (..., 3, 3)."""
    values, axes = np.linalg.eigh(S)
    return (axes * np.log(values)[..., None, :]) @ np.swapaxes(axes, -1, -2)


@pytest.mark.parametrize("uncertainty", WIDE.values(), ids=WIDE.keys())
def test_every_draw_is_a_possible_robot(uncertainty: Uncertainty) -> None:
    inertias = uncertainty.draw(PANDA, 1, range(DRAWS))["inertias"]
    assert inertias.shape == (DRAWS, len(PANDA.g0), 10)
    assert np.all(np.isfinite(inertias))
    assert np.all(inertias[..., 0] > 0)
    principal = np.linalg.eigvalsh(central_inertia(inertias))
    scale = np.abs(inertias).max(axis=-1)  # a displaced body's central inertia is a difference
    assert np.all(principal[..., 0] >= -ROUNDING * scale)
    triangle = principal[..., 0] + principal[..., 1] - principal[..., 2]
    assert np.all(triangle >= -ROUNDING * scale)
    PANDA.check_inertias(inertias)  # pseudo-inertias
    rng = np.random.default_rng(0)
    for rows in inertias[:500]:
        M = PANDA.with_inertias(rows).mass_matrix(rng.uniform(PANDA.lower, PANDA.upper))
        unit = np.sqrt(np.diag(M))  # joints differ by many digits: M in units of their own
        assert np.linalg.eigvalsh(M / np.outer(unit, unit))[0] > 0


@pytest.mark.parametrize("name", ["log-normal", "bounded"])
def test_draws_of_half_the_size_are_strictly_possible(name: str) -> None:
    inertias = WIDE[name].draw(PANDA, 2, range(DRAWS))["inertias"]
    principal = np.linalg.eigvalsh(central_inertia(inertias))
    assert np.all(principal > 0)
    assert np.all(principal[..., 0] + principal[..., 1] > principal[..., 2])


def test_a_body_that_rounding_in_its_urdf_makes_impossible_is_drawn_possible(
    urdf: Callable[..., Path],
) -> None:
    flat = link("upper", izz=0.2 * (1 + 1e-7))  # ixx + iyy is a little less
    arm = load_arm(str(urdf(robot(BASE, flat, link("lower"), SHOULDER, ELBOW))))
    with pytest.raises(ParameterError):
        arm.check_inertias(arm.inertias)
    arm.check_inertias(WIDE["log-normal"].draw(arm, 0, range(100))["inertias"])


def assert_standard(sample: Array) -> None:
    """Mean zero, variance one, normal."""
    n = sample.size
    low, high = stats.chi2.interval(CONFIDENCE, n - 1) / np.float64(n - 1)
    assert low < np.var(sample, ddof=1) < high
    assert abs(np.mean(sample)) < stats.norm.isf((1 - CONFIDENCE) / 2) / np.sqrt(n)
    assert stats.kstest(sample, "norm").pvalue > KS_SIGNIFICANCE


def assert_uniform(sample: Array, low: float, high: float) -> None:
    assert low <= sample.min()
    assert sample.max() <= high
    assert stats.kstest(sample, "uniform", (low, high - low)).pvalue > KS_SIGNIFICANCE


def drawn_deviates(two_joints: Arm, uncertainty: Uncertainty) -> dict[str, Array]:
    """What was drawn for two balls, recovered from their mass, centre and inertia."""
    inertias = uncertainty.draw(two_joints, 3, range(DRAWS))["inertias"]
    m, c = mass_and_centre(inertias)
    ball = 0.05 * np.eye(3)  # second moments of the nominal body
    E = logarithm(second_moments(inertias) / m[..., None, None] @ np.linalg.inv(ball)) / 2
    return {
        "factor": m.ravel(),
        "displacement": (c - [0.1, 0.0, 0.2]).ravel(),
        "strain": E[..., range(3), range(3)].ravel(),
        "shear": E[..., (0, 0, 1), (1, 2, 2)].ravel(),
    }


def test_log_normal_spreads_are_standard_deviations(two_joints: Arm) -> None:
    drawn = drawn_deviates(two_joints, Uncertainty(mass=0.3, centre=0.02, shape=0.1))
    assert_standard(np.log(drawn["factor"]) / 0.3)
    assert_standard(drawn["displacement"] / 0.02)
    assert_standard(drawn["strain"] / 0.1)
    assert_standard(drawn["shear"] * np.sqrt(2) / 0.1)


def test_bounded_spreads_are_bounds(two_joints: Arm) -> None:
    spread = Uncertainty(mass=0.3, centre=0.02, shape=0.1, distribution="bounded")
    drawn = drawn_deviates(two_joints, spread)
    slack = ROUNDING  # of recovering them
    assert_uniform(drawn["factor"], 0.7 - slack, 1.3 + slack)
    assert_uniform(drawn["displacement"], -0.02 - slack, 0.02 + slack)
    assert_uniform(drawn["strain"], -0.1 - slack, 0.1 + slack)
    assert_uniform(drawn["shear"] * np.sqrt(2), -0.1 - slack, 0.1 + slack)


def test_log_normal_strain_is_as_large_along_any_direction(two_joints: Arm) -> None:
    inertias = Uncertainty(shape=0.1).draw(two_joints, 4, range(DRAWS))["inertias"]
    E = logarithm(second_moments(inertias[:, 0]) / 0.05) / 2
    for direction in np.random.default_rng(0).standard_normal((4, 3)):
        x = direction / np.linalg.norm(direction)
        assert_standard((E @ x) @ x / 0.1)


def test_bodies_and_their_numbers_are_drawn_independently(two_joints: Arm) -> None:
    uncertainty = Uncertainty(mass=0.3, centre=0.02, shape=0.1)
    inertias = uncertainty.draw(two_joints, 3, range(DRAWS))["inertias"]
    m, c = mass_and_centre(inertias)
    E = logarithm(second_moments(inertias) / m[..., None, None])
    columns = [np.log(m), c.reshape(DRAWS, -1), E[..., *np.triu_indices(3)].reshape(DRAWS, -1)]
    correlations = np.corrcoef(np.concatenate(columns, axis=1).T)
    off = correlations[np.triu_indices(len(correlations), 1)]
    assert np.max(np.abs(off)) < SIGMAS / np.sqrt(DRAWS)


@pytest.mark.parametrize("distribution", ["log-normal", "bounded"])
def test_friction_is_spread_as_masses_are(distribution: str) -> None:
    uncertainty = Uncertainty(friction=0.4, distribution=distribution)  # type: ignore[arg-type]
    drawn = uncertainty.draw(XARM, 5, range(2000))
    assert sorted(drawn) == ["damping", "friction", "inertias"]
    np.testing.assert_allclose(
        drawn["inertias"], np.broadcast_to(XARM.inertias, (2000, *XARM.inertias.shape)),
        rtol=0, atol=ROUNDING,
    )  # fmt: skip
    factors = {name: drawn[name] / getattr(XARM, name) for name in ("damping", "friction")}
    for factor in factors.values():
        if distribution == "bounded":
            assert_uniform(factor.ravel(), 0.6, 1.4)
        else:
            assert_standard(np.log(factor).ravel() / 0.4)
    both = np.corrcoef(factors["damping"].ravel(), factors["friction"].ravel())[0, 1]
    assert abs(both) < SIGMAS / np.sqrt(factors["damping"].size)


def test_only_the_friction_that_there_is_is_drawn() -> None:
    arm = replace(XARM, friction=np.zeros_like(XARM.friction))
    assert sorted(Uncertainty(friction=0.1).draw(arm, 0, [0])) == ["damping", "inertias"]


@pytest.mark.parametrize("distribution", ["log-normal", "bounded"])
def test_payloads_are_uniform(two_joints: Arm, distribution: str) -> None:
    uncertainty = Uncertainty(payload=(0.5, 2.0), distribution=distribution)  # type: ignore[arg-type]
    inertias = uncertainty.draw(two_joints, 6, range(DRAWS))["inertias"]
    assert_uniform(inertias[:, 1, 0] - 1.0, 0.5, 2.0)
    np.testing.assert_allclose(inertias[:, 0, 0], 1.0, rtol=ROUNDING)


TOOL = (
    '<joint name="flange" type="fixed"><parent link="{parent}"/><child link="tool"/>'
    '<origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/></joint><link name="tool">{inside}</link>'
)
POINT_MASS = (
    '<inertial><origin xyz="0.05 0.02 -0.1"/><mass value="1.7"/>'
    '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
)
PAYLOAD = Uncertainty(payload=(1.7, 1.7), payload_frame="tool", payload_offset=(0.05, 0.02, -0.1))


def assert_same_dynamics(arm: Arm, truth: Arm) -> None:
    rng = np.random.default_rng(7)
    for _ in range(20):
        q, v = rng.uniform(-2, 2, (2, arm.n))
        for value, exact in (
            (arm.mass_matrix(q), truth.mass_matrix(q)),
            (arm.potential_force(q), truth.potential_force(q)),
            (arm.bias_force(q, v), truth.bias_force(q, v)),
        ):
            np.testing.assert_allclose(value, exact, rtol=0, atol=ROUNDING * np.abs(exact).max())


@pytest.mark.parametrize("parent", ["upper", "lower"])
def test_a_payload_is_a_point_mass_of_the_urdf(urdf: Callable[..., Path], parent: str) -> None:
    parts = (BASE, link("upper"), link("lower"), SHOULDER, ELBOW)
    texts = [robot(*parts, TOOL.format(parent=parent, inside=i)) for i in ("", POINT_MASS)]
    arm, truth = (load_arm(str(urdf(text, f"arm{i}.urdf"))) for i, text in enumerate(texts))
    assert_same_dynamics(PAYLOAD.robot(arm, 0, 0), truth)
    if parent == "lower":
        assert_same_dynamics(replace(PAYLOAD, payload_frame=None).robot(arm, 0, 0), truth)


def test_a_payload_of_a_real_arm(urdf: Callable[..., Path]) -> None:
    text = catalogue()["panda"].path().read_text()
    arms = []
    for i, inside in enumerate(("", POINT_MASS)):
        tool = TOOL.format(parent="panda_hand", inside=inside)
        file = urdf(text.replace("</robot>", f"{tool}</robot>"), f"panda{i}.urdf")
        arms.append(load_arm(str(file), lock=["panda_finger_joint1"]))
    assert_same_dynamics(PAYLOAD.robot(arms[0], 0, 0), arms[1])


@pytest.mark.parametrize(
    ("name", "tip"),
    [("panda", "panda_hand_tcp"), ("ur5", "tool0"), ("finger_edu", "finger_tip_link")],
)
def test_the_tip_carries_the_payload_unless_another_frame_is_named(name: str, tip: str) -> None:
    arm = load_arm(name)
    by_default = Uncertainty(payload=(1.0, 2.0)).draw(arm, 0, range(5))["inertias"]
    named = Uncertainty(payload=(1.0, 2.0), payload_frame=tip).draw(arm, 0, range(5))
    np.testing.assert_array_equal(by_default, named["inertias"])


ALL = Uncertainty(
    mass=0.2, centre=0.02, shape=0.1, friction=0.3, payload=(0.0, 2.0), payload_frame="link3"
)


def test_a_robot_is_the_same_alone_and_among_many() -> None:
    numbers = [*range(1030), 2**40, 2**63, 2**64 - 1]
    batch = ALL.draw(XARM, 8, numbers)
    for i in (0, 1, 511, 512, 1024, 1030, 1031, 1032):
        alone = ALL.draw(XARM, 8, [numbers[i]])
        for name, values in batch.items():
            np.testing.assert_array_equal(alone[name][0], values[i])
    inertias = batch["inertias"]
    assert len(np.unique(inertias[:, 0, 0])) == len(numbers)
    assert not np.any(inertias[:, :, 0] == ALL.draw(XARM, 9, numbers)["inertias"][:, :, 0])


def test_a_spread_changes_only_what_it_is_the_spread_of() -> None:
    lone = Uncertainty(mass=0.2).draw(XARM, 8, range(10))["inertias"]
    np.testing.assert_array_equal(
        ALL.draw(XARM, 8, range(10))["inertias"][:, 4:, 0], lone[:, 4:, 0]
    )


def test_no_path_gives_empty_arrays() -> None:
    drawn = ALL.draw(XARM, 0, [])
    assert drawn["inertias"].shape == (0, len(XARM.g0), 10)
    assert drawn["damping"].shape == (0, len(XARM.g0))


def test_what_is_not_given_is_certain(arm: Arm) -> None:
    same = Uncertainty().draw(arm, 0, [3])["inertias"][0]
    scale = np.abs(arm.inertias).max(axis=1, keepdims=True)
    assert np.all(np.abs(same - arm.inertias) <= ROUNDING * scale)


def test_massless_bodies_stay() -> None:
    arm = load_arm("double_pendulum")
    inertias = WIDE["log-normal"].draw(arm, 0, range(100))["inertias"]
    np.testing.assert_array_equal(inertias[:, arm.inertias[:, 0] == 0], 0.0)


def test_the_robot_of_a_path_is_an_arm() -> None:
    drawn, made = ALL.draw(XARM, 8, [5]), ALL.robot(XARM, 8, 5)
    slack = ROUNDING * np.abs(XARM.inertias).max()
    np.testing.assert_allclose(made.inertias, drawn["inertias"][0], rtol=0, atol=slack)
    np.testing.assert_array_equal(made.damping, drawn["damping"][0])
    np.testing.assert_array_equal(made.friction, drawn["friction"][0])
    assert made.joint_names == XARM.joint_names
    assert made.source is not None
    assert made.source["damping"] == made.damping.tolist()
    assert "damping" not in (XARM.source or {})


@pytest.mark.parametrize("field", ["mass", "centre", "shape", "friction"])
@pytest.mark.parametrize("value", [-0.1, 2.01, np.nan, np.inf, "much", None, True])
def test_impossible_spreads_are_refused(field: str, value: object) -> None:
    with pytest.raises(ParameterError) as caught:
        Uncertainty(**{field: value})  # type: ignore[arg-type]
    unit = " [m]" if field == "centre" else ""
    sentence = f"Uncertainty {field}: {value!r}, expected a number from 0 to 2{unit}"
    assert (str(caught.value), caught.value.field) == (sentence, field)


@pytest.mark.parametrize("field", ["mass", "friction"])
def test_bounded_factors_stay_positive(field: str) -> None:
    with pytest.raises(ParameterError) as caught:
        Uncertainty(**{field: 1.0}, distribution="bounded")  # type: ignore[arg-type]
    assert str(caught.value) == (
        f"Uncertainty {field}: 1.0, expected a number below 1; "
        'take distribution="log-normal" for larger spreads'
    )


def test_impossible_payloads_and_distributions_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"payload: \(2, 1\), expected 0 <= smallest <="):
        Uncertainty(payload=(2.0, 1.0))
    with pytest.raises(ParameterError, match=r"payload: \(-1, 1\), expected 0 <= smallest <="):
        Uncertainty(payload=(-1.0, 1.0))
    with pytest.raises(ShapeError, match="Uncertainty payload"):
        Uncertainty(payload=(0.0, np.inf))
    with pytest.raises(ShapeError, match=r"payload_offset: shape \(2,\)"):
        Uncertainty(payload=(0.0, 1.0), payload_offset=(0.0, 1.0))  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"no payload, .*; give payload=\(smallest, largest\)"):
        Uncertainty(payload_frame="tool")
    with pytest.raises(UnknownNameError, match=r"distribution 'normal'.*log-normal, bounded"):
        Uncertainty(distribution="normal")  # type: ignore[arg-type]


def test_what_an_arm_does_not_have_is_refused_at_the_draw(two_joints: Arm) -> None:
    with pytest.raises(ParameterError, match="uncertain friction of arm: no friction"):
        Uncertainty(friction=0.1).draw(two_joints, 0, [0])
    with pytest.raises(UnknownNameError, match=r"payload_frame of arm 'hand'.*upper.*lower"):
        Uncertainty(payload=(0, 1), payload_frame="hand").robot(two_joints, 0, 0)
    with pytest.raises(
        ParameterError, match=r"'base' of arm: a frame that no joint moves.*'lower'"
    ):
        Uncertainty(payload=(0, 1), payload_frame="base").draw(two_joints, 0, [0])


@pytest.mark.parametrize(("seed", "path"), [(-1, 0), (0, -1), (2**64, 0), (0, 2**64), (0, 0.5)])
def test_what_is_no_seed_or_path_is_refused(seed: int, path: int) -> None:
    with pytest.raises(ParameterError, match=r"expected an integer from 0 to 2\^64 - 1"):
        Uncertainty(mass=0.1).draw(PANDA, seed, [path])
