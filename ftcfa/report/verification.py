"""A verification as its user reads it: the answer, what it rests on, and how to see the worst."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from ftcfa.study.verification import Verification


def verification_record(found: Verification, file: str, duration: float) -> dict[str, Any]:
    """All that `ftcfa verify` shows, as plain data.

    Args:
        found: Of `ftcfa.verify`.
        file: The experiment's file, by which a path can be run again.
        duration: Of a run [s].
    """
    asked, verdict = found.specification, found.verdict
    return {
        "answer": found.answer,
        "kept": verdict.successes,
        "paths": verdict.trials,
        "share": {"low": verdict.low, "high": verdict.high},
        "all_paths": dict(zip(("share", "low", "high"), map(float, found.fixed), strict=True)),
        "specification": {
            "error": asked.error,
            "within": asked.within,
            "effort": _limit(asked.effort),
            "torque_rate": _limit(asked.torque_rate),
            "share": asked.share,
            "confidence": asked.confidence,
            "budget": asked.budget,
        },
        "seed": found.seed,
        "duration": duration,
        "worst": [
            {
                "path": one.path,
                "reason": one.reason,
                "excess": one.excess if math.isfinite(one.excess) else None,
                "replay": _replay(file, duration, found.seed, one.path),
            }
            for one in found.worst
        ],
    }


def _limit(limit: Any) -> Any:
    return None if limit is None else np.asarray(limit, dtype=float).tolist()


def _replay(file: str, duration: float, seed: int, path: int) -> str:
    loop = f"ftcfa.load_experiment({file!r}).loop"
    return f'ftcfa.simulate({loop}, {duration!r}, seed={seed}, path={path}, signals="all")'


def print_verification(record: Mapping[str, Any], console: Console) -> None:
    """Write the answer and what it rests on.

    Args:
        record: Of `verification_record`.
        console: Where to write.
    """
    asked, share = record["specification"], record["share"]
    console.print(record["answer"], style="bold", markup=False)
    facts = Table.grid(padding=(0, 2))
    facts.add_column(style="dim", no_wrap=True)
    facts.add_column(overflow="fold")
    facts.add_row("asked", _asked(asked))
    facts.add_row("kept by", f"{record['kept']:,} of {record['paths']:,} paths")
    facts.add_row(
        "share",
        f"{share['low']:.4g} or more, {share['high']:.4g} or less, each with confidence "
        f"{asked['confidence']:g}; asked for is {asked['share']:g}",
    )
    if record["answer"] == "undecided" and record["paths"] == asked["budget"]:
        exact = record["all_paths"]
        facts.add_row(
            "exact",
            f"{exact['low']:.4g} to {exact['high']:.4g}, Clopper and Pearson's interval",
        )
    console.print(facts, highlight=False, markup=False)
    if not record["worst"]:
        return
    console.print("\nworst paths", style="bold")
    for one in record["worst"]:
        console.print(f"path {one['path']}: {one['reason']}", markup=False)
    console.print("\nto see the worst one", style="dim")
    console.print(record["worst"][0]["replay"], markup=False, soft_wrap=True)


def _asked(asked: Mapping[str, Any]) -> str:
    words = [f"settles to {asked['error']:g} within {asked['within']:g} s"]
    for name, label in (("effort", "|u|"), ("torque_rate", "torque rate")):
        if asked[name] is not None:
            words.append(f"{label} at most {np.array2string(np.asarray(asked[name]))}")
    return f"{', '.join(words)}, by a share of {asked['share']:g} of all runs"
