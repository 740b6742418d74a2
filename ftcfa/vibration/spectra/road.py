"""Road roughness by ISO 8608 classes, through a quarter-car to the floor of the vehicle.

A road's height over its length has the one-sided displacement density

    G_d(n) = G_d(n_0) (n/n_0)^-2,   n_0 = 0.1 cycles/m                                [m^3]

At the speed V a spatial frequency n is met as f = V n, and the density per hertz is G_d(n)/V. The
rate of change of the height, z', then has the density

    (2 pi f)^2 G_d(n_0) n_0^2 (V/f)^2 / V = 4 pi^2 G_d(n_0) n_0^2 V                   [(m/s)^2/Hz]

which does not depend on f: the road's velocity is white noise. Its intensity is half of the
one-sided density per hertz:

    varpi = 2 pi^2 G_d(n_0) n_0^2 V,   E[z'(t) z'(s)] = varpi delta(t - s)            [m^2/s]

Provenance: the text of the standard was not available. The exponent, the reference frequency and
the geometric means of the classes (16e-6 m^3 for A, four times as much for each next class) are
quoted from it in the open literature. The standard describes roads from about 0.01 to 10 cycles/m,
and the model continues the line beyond. Longer waves hardly accelerate the vehicle. Shorter waves,
which the contact patch of a tyre bridges, are far above the resonance of the wheel.
"""

from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np

from ftcfa.checks import Check, known_name, positive
from ftcfa.errors import ParameterError
from ftcfa.parts import Part
from ftcfa.vibration.spectra.linear_filter import LinearFilter

PROVENANCE = "ISO 8608 as quoted in the open literature; unverified in the standard itself"
REFERENCE_FREQUENCY = 0.1
"""n_0 [cycles/m]."""
ROAD_CLASSES = {"A": 16e-6, "B": 64e-6, "C": 256e-6, "D": 1024e-6, "E": 4096e-6, "F": 16384e-6}
"""Geometric means of G_d(n_0), from very good (A) to very poor (E) and worse [m^3]."""


@dataclass(frozen=True)
class QuarterCar(Part):
    """A wheel and its share of the body: two masses, a suspension, a tyre without damping.

        m_s z_s'' = -k_s (z_s - z_u) - c_s (z_s' - z_u')
        m_u z_u'' =  k_s (z_s - z_u) + c_s (z_s' - z_u') - k_t (z_u - z_r)

    Attributes:
        sprung_mass: m_s, the body's share [kg].
        unsprung_mass: m_u, wheel and axle [kg].
        suspension_stiffness: k_s [N/m].
        suspension_damping: c_s [N s/m].
        tyre_stiffness: k_t [N/m].
    """

    sprung_mass: Annotated[float, Check(positive, "kg")]
    unsprung_mass: Annotated[float, Check(positive, "kg")]
    suspension_stiffness: Annotated[float, Check(positive, "N/m")]
    suspension_damping: Annotated[float, Check(positive, "N s/m")]
    tyre_stiffness: Annotated[float, Check(positive, "N/m")]

    def filter(self) -> LinearFilter:
        """Filter from the road's velocity z_r', white of intensity 1 m^2/s, to z_s''.

        The states are (z_s - z_u, z_s', z_u - z_r, z_u'). The road enters only by its velocity, so
        no state drifts as the road's height does.
        """
        ms, mu = self.sprung_mass, self.unsprung_mass
        ks, cs, kt = self.suspension_stiffness, self.suspension_damping, self.tyre_stiffness
        A = [
            [0.0, 1.0, 0.0, -1.0],
            [-ks / ms, -cs / ms, 0.0, cs / ms],
            [0.0, 0.0, 0.0, 1.0],
            [ks / mu, cs / mu, -kt / mu, -cs / mu],
        ]
        B = [[0.0], [0.0], [-1.0], [0.0]]
        return LinearFilter(np.array(A), np.array(B), np.array(A[1:2]))


PASSENGER_CAR = QuarterCar(250.0, 37.5, 63.3 * 250.0, 6.0 * 250.0, 653.0 * 250.0)
"""The ratios of the International Roughness Index's reference car (Sayers, Gillespie and Queiroz
1986; ASTM E1926): k_s/m_s = 63.3 s^-2, k_t/m_s = 653 s^-2, c_s/m_s = 6.0 s^-1, m_u/m_s = 0.15;
250 kg is a round number. Body 1.2 Hz, wheel 11 Hz."""
TRUCK = QuarterCar(4500.0, 500.0, 7e5, 2e4, 1.8e6)
"""One end of a loaded truck's axle, in round numbers from no single source. Body 1.7 Hz, wheel
11 Hz."""


def check_vehicle(subject: str, vehicle: Any) -> None:
    """Raise ParameterError unless a vehicle is a quarter-car, or a filter of one input."""
    if not isinstance(vehicle, QuarterCar | LinearFilter):
        raise ParameterError(subject, repr(vehicle), "a QuarterCar or a LinearFilter")
    if isinstance(vehicle, LinearFilter) and vehicle.inputs != 1:
        raise ParameterError(subject, f"a filter of {vehicle.inputs} inputs", "one input, z_r'")


@dataclass(frozen=True, eq=False)
class Road(Part):
    """A vehicle's floor on a road: one axis of `ShapedNoise`.

    Attributes:
        road_class: "A" to "F" of ISO 8608.
        speed: V [m/s].
        vehicle: A quarter-car, or a filter of your own from the road's velocity, white of
            intensity 1 m^2/s, to accelerations.

    Raises:
        UnknownNameError: If there is no such class.
        ParameterError: If the speed is not above zero, or the vehicle is none.
    """

    road_class: Annotated[str, Check(partial(known_name, known=ROAD_CLASSES))]
    speed: Annotated[float, Check(positive, "m/s")]
    vehicle: Annotated[QuarterCar | LinearFilter, Check(check_vehicle)] = PASSENGER_CAR

    @property
    def velocity_intensity(self) -> float:
        """Intensity varpi = 2 pi^2 G_d(n_0) n_0^2 V of the road's white velocity [m^2/s]."""
        roughness = ROAD_CLASSES[self.road_class]
        return 2.0 * np.pi**2 * roughness * REFERENCE_FREQUENCY**2 * self.speed

    def filter(self) -> LinearFilter:
        """Filter from white noise of unit intensity to the acceleration of the floor [m/s^2]."""
        vehicle = self.vehicle.filter() if isinstance(self.vehicle, QuarterCar) else self.vehicle
        return vehicle.scaled(float(np.sqrt(self.velocity_intensity)))
