"""References: derivatives against differences, broadcasting, files, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ftcfa import (
    ClosedLoop,
    Constant,
    MinimumJerk,
    ParameterError,
    PDGravity,
    ShapeError,
    Sinusoid,
    Table,
    load_arm,
)

STEP = 1e-4
"""Of the central differences [s]."""
DIFFERENCE = 5e-5
"""Their own error, h^2/6 times a derivative of up to 2e4, where a wrong one would be off by 1."""
ROUNDING = 1e-12

TIMES = [0.5, 1.0, 2.5, 3.0]
POINTS = [[0.0, 1.0], [0.5, -1.0], [0.5, 2.0], [-0.3, 2.5]]
SMOOTH = {
    "constant": Constant([0.3, -1.2]),
    "sinusoid": Sinusoid([1.5, 1.0], [1.0, 2.0], [0.3, 0.0], [0.1, -0.2]),
    "minimum jerk": MinimumJerk(TIMES, POINTS),
    "table": Table(TIMES, POINTS),
}


@pytest.mark.parametrize("reference", SMOOTH.values(), ids=SMOOTH.keys())
def test_velocity_and_acceleration_are_the_derivatives(reference):
    rng = np.random.default_rng(0)
    t = rng.uniform(0.0, 4.0, 200)
    knots = np.array(TIMES)
    t = t[np.min(np.abs(t[:, None] - knots), axis=1) > 2 * STEP]  # where a third derivative jumps
    before, now, after = (reference.at(t + dt) for dt in (-STEP, 0.0, STEP))
    assert now.q.shape == now.v.shape == now.a.shape == (len(t), reference.n)
    np.testing.assert_allclose((after.q - before.q) / (2 * STEP), now.v, rtol=0, atol=DIFFERENCE)
    np.testing.assert_allclose((after.v - before.v) / (2 * STEP), now.a, rtol=0, atol=DIFFERENCE)


def test_constant_stands_still():
    desired = Constant([0.3, -1.2]).at(np.array([0.0, 7.0]))
    np.testing.assert_array_equal(desired.q, [[0.3, -1.2]] * 2)
    np.testing.assert_array_equal(desired.v, 0.0)
    np.testing.assert_array_equal(desired.a, 0.0)


def test_sinusoid_is_its_formula_joint_by_joint():
    """The paper's q_d = (1.5 sin t, sin 2t)."""
    t = np.linspace(0.0, 20.0, 50)
    desired = Sinusoid([1.5, 1.0], [1.0, 2.0]).at(t)
    expected = np.column_stack([1.5 * np.sin(t), np.sin(2.0 * t)])
    np.testing.assert_allclose(desired.q, expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("longest", ["amplitude", "angular_frequency", "phase", "offset"])
def test_the_longest_parameter_of_a_sinusoid_gives_the_joints(longest):
    values = {"amplitude": 0.3, "angular_frequency": 2.0, "phase": 0.1, "offset": -0.5}
    given_by = Sinusoid(**{**values, longest: [values[longest]] * 3})
    assert given_by.n == 3
    t = np.linspace(0.0, 1.0, 5)
    np.testing.assert_array_equal(
        given_by.at(t).q, np.repeat(Sinusoid(**values).at(t).q, 3, axis=1)
    )


def test_parameters_of_two_lengths_are_refused():
    message = r"Sinusoid angular_frequency: .*, expected 1 or 3 finite numbers"
    with pytest.raises(ShapeError, match=message):
        Sinusoid([0.1, 0.2, 0.3], [1.0, 2.0])


def test_a_frequency_of_a_sinusoid_is_refused_with_the_name_of_the_angular_frequency():
    with pytest.raises(ParameterError) as refused:
        Sinusoid(amplitude=0.3, frequency=1.0)
    assert str(refused.value) == (
        "Sinusoid frequency: 1.0, expected angular_frequency [rad/s]; multiply a "
        "frequency in Hz by 2 pi"
    )


@pytest.mark.parametrize("bad", [[], [[0.1, 0.2]], np.nan, [0.1, np.inf]])
def test_what_is_no_row_of_numbers_is_refused(bad):
    with pytest.raises(ShapeError, match=r"Constant q: .* finite numbers, one for each joint"):
        Constant(bad)
    with pytest.raises(ShapeError, match="Sinusoid offset"):
        Sinusoid(offset=bad)


@pytest.mark.parametrize("bad", ["up", None.__class__, [[0.1], [0.1, 0.2]], ["a", 1.0]])
def test_what_is_no_number_is_refused(bad):
    with pytest.raises(ParameterError, match=r"Constant q: .*, expected numbers"):
        Constant(bad)
    with pytest.raises(ParameterError, match=r"Table points: .*, expected numbers"):
        Table([0.0, 1.0], bad)


@pytest.mark.parametrize("kind", [MinimumJerk, Table])
def test_waypoints_are_met(kind):
    np.testing.assert_allclose(
        kind(TIMES, POINTS).at(np.array(TIMES)).q, POINTS, rtol=0, atol=ROUNDING
    )


def test_minimum_jerk_rests_at_every_waypoint():
    desired = MinimumJerk(TIMES, POINTS).at(np.array(TIMES))
    np.testing.assert_allclose(desired.v, 0.0, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(desired.a, 0.0, rtol=0, atol=ROUNDING)


def test_minimum_jerk_is_half_way_at_half_time_with_the_known_top_speed():
    """15/8 of the mean speed (Flash and Hogan 1985)."""
    desired = MinimumJerk([1.0, 3.0], [[0.0], [4.0]]).at(np.array([2.0]))
    assert desired.q[0, 0] == pytest.approx(2.0)
    assert desired.v[0, 0] == pytest.approx(15.0 / 8.0 * 4.0 / 2.0)
    assert desired.a[0, 0] == pytest.approx(0.0)


@given(t=st.floats(0.5, 3.0))
def test_minimum_jerk_stays_between_its_waypoints(t):
    q = MinimumJerk(TIMES, POINTS).at(np.array([t])).q
    i = max(k for k in range(3) if TIMES[k] <= t)
    low, high = np.minimum(POINTS[i], POINTS[i + 1]), np.maximum(POINTS[i], POINTS[i + 1])
    assert np.all((q >= low - ROUNDING) & (q <= high + ROUNDING))


@pytest.mark.parametrize("kind", [MinimumJerk, Table])
def test_the_ends_are_held(kind):
    desired = kind(TIMES, POINTS).at(np.array([-1e9, 0.0, 0.499, 3.001, 1e9]))
    expected = [POINTS[0]] * 3 + [POINTS[-1]] * 2
    np.testing.assert_allclose(desired.q, expected, rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal(desired.v, 0.0)
    np.testing.assert_array_equal(desired.a, 0.0)


def test_a_table_starts_and_ends_at_rest():
    desired = Table(TIMES, POINTS).at(np.array([TIMES[0], TIMES[-1]]))
    np.testing.assert_allclose(desired.v, 0.0, rtol=0, atol=ROUNDING)


def test_a_table_of_a_cubic_is_that_cubic():
    """3 t^2 - 2 t^3 rests at 0 and 1: the one clamped spline through its points is itself."""
    knots = np.linspace(0.0, 1.0, 6)
    table = Table(knots, (3.0 * knots**2 - 2.0 * knots**3)[:, None])
    t = np.linspace(0.0, 1.0, 31)
    desired = table.at(t)
    np.testing.assert_allclose(desired.q[:, 0], 3 * t**2 - 2 * t**3, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(desired.v[:, 0], 6 * t - 6 * t**2, rtol=0, atol=10 * ROUNDING)
    np.testing.assert_allclose(desired.a[:, 0], 6 - 12 * t, rtol=0, atol=100 * ROUNDING)


@pytest.mark.parametrize("kind", [MinimumJerk, Table])
@pytest.mark.parametrize(
    ("times", "points", "error", "text"),
    [
        ([0.0, 1.0], [[0.0]], ShapeError, "points"),
        ([0.0], [[0.0]], ShapeError, "P >= 2"),
        ([0.0, 1.0], [0.0, 1.0], ShapeError, "points"),
        ([0.0, 2.0, 1.0], [[0.0]] * 3, ParameterError, "time 1.0 follows 2.0, expected increasing"),
        ([0.0, 1.0, 1.0], [[0.0]] * 3, ParameterError, "time 1.0 follows 1.0, expected increasing"),
        ([0.0, np.nan], [[0.0]] * 2, ParameterError, "row 1 is nan.*, expected finite numbers"),
        ([0.0, 1.0], [[0.0], [np.inf]], ParameterError, "row 1 is 1.0.*, expected finite numbers"),
    ],
)
def test_bad_waypoints_are_refused(kind, times, points, error, text):
    with pytest.raises(error, match=text):
        kind(times, points)


ROWS = "0.0,0.1,0.2\n0.5,0.3,0.4\n1.5,-1e-1,2E0\n"


@pytest.mark.parametrize(
    "text",
    [
        ROWS,
        "time,shoulder,elbow\n" + ROWS,
        "# planned by hand\n\nt [s],q1 [rad],q2 [rad]\n# units above\n" + ROWS,
        "\ufeff" + ROWS,  # as spreadsheets save it
        "\ufefftime,shoulder,elbow\r\n" + ROWS.replace("\n", "\r\n"),
        ROWS.replace("0.4", " 0.4 # a comment"),
    ],
)
def test_a_csv_file_is_read(tmp_path, text):
    file = tmp_path / "motion.csv"
    file.write_text(text, encoding="utf-8")
    table = Table.from_file(file)
    assert table.n == 2
    np.testing.assert_array_equal(table.times, [0.0, 0.5, 1.5])
    np.testing.assert_array_equal(table.points, [[0.1, 0.2], [0.3, 0.4], [-0.1, 2.0]])
    np.testing.assert_array_equal(Table.from_file(str(file)).points, table.points)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "empty"),
        ("# nothing\n", "empty"),
        ("time,q\n", "no samples, expected two or more"),
        ("0.0,0.1\n", "1 samples, expected two or more"),
        ("0.0\n1.0\n", "1 column, expected a column of times, then one column for each joint"),
        ("0.0,0.1\n1.0,abc\n", r"row 2, column 2: 'abc', expected a number"),
        ("0.0,abc\n1.0,0.2\n2.0,0.3\n", r"row 1, column 2: 'abc', expected a number"),
        ("0.0,0.1\n1.0\n", "row 2: 1 columns, expected 2 columns"),
        ("nan,0.1\n1.0,0.2\n2.0,0.3\n", "row 1, column 1: nan"),
        ("0.0,0.1\n1.0,nan\n", "row 2, column 2: nan"),
        ("0.0,0.1\n2.0,0.2\n1.0,0.3\n", "time 1.0 follows 2.0, expected increasing times"),
    ],
)
def test_a_bad_file_is_refused_by_name(tmp_path, text, complaint):
    file = tmp_path / "motion.csv"
    file.write_text(text)
    with pytest.raises(ParameterError, match=f"motion.csv: .*{complaint}"):
        Table.from_file(file)


def test_a_missing_or_binary_file_is_refused_by_name(tmp_path):
    with pytest.raises(ParameterError, match=r"none\.csv: no such file .*expected a readable"):
        Table.from_file(tmp_path / "none.csv")
    binary = tmp_path / "binary.csv"
    binary.write_bytes(bytes(range(256)))
    with pytest.raises(ParameterError, match=r"binary\.csv: "):
        Table.from_file(binary)
    with pytest.raises(ParameterError, match="is a directory"):
        Table.from_file(tmp_path)


def test_columns_go_by_the_names_of_the_joints(tmp_path):
    """As ROS writes them: sorted by name, wherever the joints stand in the arm."""
    file = tmp_path / "motion.csv"
    arm = load_arm("double_pendulum")
    shoulder, elbow = arm.joint_names
    file.write_text(f"time [s],{elbow} [rad],{shoulder} [rad]\n" + ROWS)
    table = Table.from_file(file)
    loop = ClosedLoop(arm, PDGravity(arm), table)
    np.testing.assert_array_equal(loop.reference.points, table.points[:, ::-1])
    assert loop.reference.joints == arm.joint_names
    unnamed = ClosedLoop(arm, PDGravity(arm), Table(table.times, table.points))
    np.testing.assert_array_equal(unnamed.reference.points, table.points)


@pytest.mark.parametrize(
    ("names", "complaint"),
    [
        (
            ("elbow", "wrist"),
            "columns elbow, wrist; unknown: wrist; missing: shoulder, expected one",
        ),
        (("elbow", "elbow"), "columns elbow, elbow; missing: shoulder, exp"),
        (("q1", "q2"), "unknown: q1, q2; missing: shoulder, elbow, .* or leave the header out"),
    ],
)
def test_columns_of_other_joints_are_refused(names, complaint):
    arm = load_arm("double_pendulum")
    with pytest.raises(ParameterError, match=complaint) as caught:
        ClosedLoop(arm, PDGravity(arm), Table([0.0, 1.0], np.zeros((2, 2)), names))
    assert caught.value.field == "reference"
