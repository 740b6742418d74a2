"""All kernels by name, and their version."""

from collections.abc import Callable, Mapping

from ftcfa.engine.compiler.kernels import exponential, inverse, logarithm, power, trigonometric

KERNELS = 1
"""Version of the kernels: another one gives other last bits."""
FUNCTIONS: Mapping[str, Callable[..., str]] = {
    "exp": exponential.exp,
    "expm1": exponential.expm1,
    "sinh": exponential.sinh,
    "cosh": exponential.cosh,
    "tanh": exponential.tanh,
    "log": logarithm.log,
    "log1p": logarithm.log1p,
    "asinh": logarithm.asinh,
    "acosh": logarithm.acosh,
    "atanh": logarithm.atanh,
    "sin": trigonometric.sin,
    "cos": trigonometric.cos,
    "tan": trigonometric.tan,
    "asin": inverse.asin,
    "acos": inverse.acos,
    "atan": inverse.atan,
    "atan2": inverse.atan2,
    "erf": inverse.erf,
    "hypot": inverse.hypot,
    "pow": power.power,
}
"""(asm, values) -> value, by the function's name."""
