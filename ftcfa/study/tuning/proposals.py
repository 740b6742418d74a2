"""Who proposes candidates: CMA-ES for one cost, Optuna's NSGA-II for two (extra ``tune``).

CMA-ES is that of the library cmaes, which Optuna wraps too, but with arguments that it is about to
remove. Both are asked for a generation at a time and told its order or its costs. They draw from a
seed alone, so that a search that is told the same again goes the same way: so one resumes.
"""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import FtcfaError
from ftcfa.study.tuning.objective import Score

SIGMA = 0.15
"""First standard deviation of CMA-ES, as a share of each logarithmic range."""
EDGE = 1e-3
"""Distance that the mean of CMA-ES keeps from the ends of each range at first."""
EXCESS = "excess"
"""Attribute of a trial that tells NSGA-II how far it exceeds the limits."""


def _library(name: str) -> Any:
    """A library of the extra ``tune``.

    Raises:
        FtcfaError: If it is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        remedy = 'install the extra: pip install "ftcfa[tune]"'
        raise FtcfaError("tune", f"{name} is not installed", "", remedy) from error


class OneCost:
    """Proposals for one cost: CMA-ES.

    Args:
        start: Where it starts, shape (d,), each within [0, 1].
        candidates: Number of candidates of a generation.
        seed: Seed of the proposals.

    Raises:
        FtcfaError: If the extra ``tune`` is not installed.
    """

    def __init__(self, start: Array, candidates: int, seed: int) -> None:
        self._cma = _library("cmaes").CMA(
            np.clip(start, EDGE, 1.0 - EDGE),
            SIGMA,
            bounds=np.tile([0.0, 1.0], (len(start), 1)),
            seed=seed % 2**32,
            population_size=candidates,
        )
        self._asked: list[Array] = []

    def ask(self) -> Array:
        """The next generation, shape (candidates, d), each entry within [0, 1]."""
        self._asked = [self._cma.ask() for _ in range(self._cma.population_size)]
        return np.array(self._asked)

    def tell(self, order: Sequence[int]) -> None:
        """Tell the generation that was asked for, the best first."""
        self._cma.tell([(self._asked[i], float(place)) for place, i in enumerate(order)])


class TwoCosts:
    """Proposals for the front of two costs: NSGA-II.

    Args:
        start: The loop as given, shape (d,), one of the first generation.
        candidates: Number of candidates of a generation.
        seed: Seed of the proposals.
    """

    def __init__(self, start: Array, candidates: int, seed: int) -> None:
        optuna = _library("optuna")
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        unit = optuna.distributions.FloatDistribution(0.0, 1.0)
        self._ranges = {f"x{i}": unit for i in range(len(start))}
        with _quiet():
            sampler = optuna.samplers.NSGAIISampler(
                population_size=candidates,
                seed=seed % 2**32,
                constraints_func=lambda trial: (trial.user_attrs[EXCESS],),
            )
        self._study = optuna.create_study(directions=["minimize"] * 2, sampler=sampler)
        self._study.enqueue_trial(dict(zip(self._ranges, start.tolist(), strict=True)))
        self._candidates = candidates
        self._asked: list[Any] = []

    def ask(self) -> Array:
        """The next generation, shape (candidates, d), each entry within [0, 1]."""
        with _quiet():
            self._asked = [self._study.ask(self._ranges) for _ in range(self._candidates)]
        return np.array([[trial.params[name] for name in self._ranges] for trial in self._asked])

    def tell(self, first: Score, second: Score) -> None:
        """Tell both scores of the generation that was asked for."""
        rows = zip(self._asked, first.excess, first.cost, second.cost, strict=True)
        for trial, excess, *costs in rows:
            trial.set_user_attr(EXCESS, float(excess))
            self._study.tell(trial, [float(min(cost, LARGEST)) for cost in costs])


LARGEST = 1e9
"""A cost that stands for all larger ones."""


@contextmanager
def _quiet() -> Iterator[None]:
    """Without Optuna's warnings of experimental parts."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
