"""Road classes, the white velocity of a road, and the quarter-car by its transfer function."""

import math

import numpy as np
import pytest

from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.vibration.spectra.linear_filter import LinearFilter
from ftcfa.vibration.spectra.road import PASSENGER_CAR, ROAD_CLASSES, TRUCK, QuarterCar, Road

FREQUENCIES = np.geomspace(0.05, 200.0, 300)


def road_density(road_class, n):
    """Displacement density of a road over its spatial frequency [cycles/m] -> [m^3]."""
    return ROAD_CLASSES[road_class] * (n / 0.1) ** -2


def body_over_road(car, f):
    """z_s/z_r from the two equations of motion solved by hand."""
    s = 2j * np.pi * f
    strut = car.suspension_stiffness + car.suspension_damping * s
    body = car.sprung_mass * s**2 + strut
    wheel = car.unsprung_mass * s**2 + strut + car.tyre_stiffness
    return strut * car.tyre_stiffness / (body * wheel - strut**2)


def test_the_classes_are_four_times_apart():
    assert list(ROAD_CLASSES) == list("ABCDEF")
    assert ROAD_CLASSES["A"] == 16e-6
    values = list(ROAD_CLASSES.values())
    np.testing.assert_allclose(np.divide(values[1:], values[:-1]), 4.0)


@pytest.mark.parametrize("road_class", "ABCDEF")
def test_the_velocity_of_a_road_is_white(road_class):
    """(2 pi f)^2 G_d(f/V)/V at any frequency is twice the intensity."""
    speed = 17.0
    one_sided = (
        (2 * np.pi * FREQUENCIES) ** 2 * road_density(road_class, FREQUENCIES / speed) / speed
    )
    np.testing.assert_allclose(one_sided, 2.0 * Road(road_class, speed).velocity_intensity)


@pytest.mark.parametrize("car", [PASSENGER_CAR, TRUCK, QuarterCar(300.0, 40.0, 2e4, 1e3, 2e5)])
@pytest.mark.parametrize(("road_class", "speed"), [("A", 30.0), ("C", 20.0), ("F", 3.0)])
def test_the_floor_by_the_transfer_function(car, road_class, speed):
    """S_a(f) = (2 pi f)^4 |z_s/z_r|^2 G_d(f/V)/V."""
    f = FREQUENCIES
    road = road_density(road_class, f / speed) / speed
    exact = (2 * np.pi * f) ** 4 * np.abs(body_over_road(car, f)) ** 2 * road
    np.testing.assert_allclose(Road(road_class, speed, car).filter().density(f)[:, 0], exact)


@pytest.mark.parametrize(("car", "body", "wheel"), [(PASSENGER_CAR, 1.2, 11.0), (TRUCK, 1.7, 11.0)])
def test_the_resonances_are_where_they_are_said_to_be(car, body, wheel):
    ms, mu, ks, kt = (
        car.sprung_mass,
        car.unsprung_mass,
        car.suspension_stiffness,
        car.tyre_stiffness,
    )
    squares = np.linalg.eigvals([[ks / ms, -ks / ms], [-ks / mu, (ks + kt) / mu]])
    np.testing.assert_allclose(np.sort(np.sqrt(squares)) / (2 * np.pi), [body, wheel], rtol=0.04)


def test_the_level_on_a_good_road_is_a_car_s():
    """0.2 to 1 m/s^2 is what cars show on asphalt at 25 m/s: no factor of ten is missing."""
    assert 0.2 < float(Road("A", 25.0).filter().rms()[0]) < 1.0
    twice = Road("A", 50.0).filter().rms() / Road("A", 25.0).filter().rms()
    assert twice == pytest.approx(math.sqrt(2.0))
    worse = Road("B", 25.0).filter().rms() / Road("A", 25.0).filter().rms()
    assert worse == pytest.approx(2.0)


def test_a_vehicle_of_ones_own():
    own = LinearFilter([[-5.0]], [[1.0]], [[-2.0]])
    f = np.array([0.1, 1.0, 10.0])
    varpi = Road("B", 10.0).velocity_intensity
    np.testing.assert_allclose(
        Road("B", 10.0, own).filter().density(f)[:, 0],
        2.0 * varpi * 4.0 / (25.0 + (2 * np.pi * f) ** 2),
    )


def test_an_unknown_class_lists_the_known():
    with pytest.raises(UnknownNameError) as refused:
        Road("G", 10.0)
    assert str(refused.value) == (
        "Road road_class 'G': unknown name, expected one of: A, B, C, D, E, F"
    )


@pytest.mark.parametrize("speed", [0, -1.0, np.nan, "fast"])
def test_a_speed_is_positive(speed):
    with pytest.raises(ParameterError, match=r"Road speed: .*, expected a number > 0 \[m/s\]"):
        Road("A", speed)


def test_what_is_no_vehicle_is_refused():
    with pytest.raises(
        ParameterError, match="QuarterCar tyre_stiffness: -1, expected a number > 0"
    ):
        QuarterCar(1, 1, 1, 1, -1)
    with pytest.raises(ParameterError, match="Road vehicle: 'bus', expected a QuarterCar"):
        Road("A", 10.0, "bus")
    two = LinearFilter([[-1.0]], [[1.0, 1.0]], [[1.0]])
    with pytest.raises(ParameterError, match="Road vehicle: a filter of 2 inputs, expected"):
        Road("A", 10.0, two)


@pytest.mark.parametrize("car", [PASSENGER_CAR, TRUCK])
def test_the_integral_of_the_floor_s_acceleration_is_its_velocity(car):
    """W = z_s', the second state, exactly."""
    E, integrable = car.filter().integral()
    np.testing.assert_array_equal(integrable, [True])
    np.testing.assert_allclose(E, [[0.0, 1.0, 0.0, 0.0]], atol=1e-12)
