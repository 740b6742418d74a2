"""The answer of a verification as plain data and as text, with how to see the worst path."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.console import Console

from ftcfa.report.records import finite
from ftcfa.report.terminal import print_facts, print_line
from ftcfa.study.verification import Verification


def verification_record(
    verification: Verification, file: str, duration: float, hardware: str | None = None
) -> dict[str, Any]:
    """All that ``ftcfa verify`` shows, as plain data.

    Args:
        verification: Result of `ftcfa.verify`.
        file: File of the experiment, with which a path can be run again.
        duration: Simulated time of a run [s].
        hardware: Profile that replaced the hardware of the file, or None.
    """
    required, verdict = verification.specification, verification.verdict
    share, low, high = verification.fixed
    options = "" if hardware is None else f", hardware={hardware!r}"
    loop = f"ftcfa.load_experiment({file!r}{options}).loop"
    return {
        "answer": verification.answer,
        "kept": verdict.successes,
        "paths": verdict.trials,
        "broke_limits": verification.broke_limits,
        "share": {"low": verdict.low, "high": verdict.high},
        "all_paths": {"share": float(share), "low": float(low), "high": float(high)},
        "specification": {
            **vars(required),
            "error": finite(required.error),
            "errors": required.errors,
            "effort": _limit(required.effort),
            "torque_rate": _limit(required.torque_rate),
        },
        "seed": verification.seed,
        "duration": duration,
        "worst": [
            {
                "path": one.path,
                "reason": one.reason,
                "excess": finite(one.excess),
                "replay": _replay(loop, duration, verification.seed, one.path),
            }
            for one in verification.worst
        ],
    }


def _limit(limit: Any) -> Any:
    """A limit of every joint as plain data, or None."""
    return None if limit is None else np.asarray(limit, dtype=float).tolist()


def _replay(loop: str, duration: float, seed: int, path: int) -> str:
    """The Python expression that runs a path again with all signals."""
    return f'ftcfa.simulate({loop}, {duration!r}, seed={seed}, path={path}, signals="all")'


def print_verification(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `verification_record`: the answer, and what it rests on."""
    print_line(record["answer"], console, "bold")
    print_facts(_facts(record), console)
    if not record["worst"]:
        return
    console.print("\nworst paths", style="bold")
    for one in record["worst"]:
        print_line(f"path {one['path']}: {one['reason']}", console)
    console.print("\nto see the worst one, in Python", style="dim")
    console.print(record["worst"][0]["replay"], markup=False, soft_wrap=True)


def _facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of the requirement and of what the paths did."""
    required, share = record["specification"], record["share"]
    facts = [
        ("required", _requirement(required)),
        ("kept by", f"{record['kept']:,} of {record['paths']:,} paths{_limits(record)}"),
        ("share", f"{share['low']:.4g} or more, {share['high']:.4g} or less, each with confidence "
                  f"{required['confidence']:g}; required is {required['share']:g}"),
    ]  # fmt: skip
    if record["answer"] != "undecided":
        text = f"after {record['paths']:,} of at most {required['budget']:,} paths"
        facts.append(("decided", text))
    elif record["paths"] == required["budget"]:
        exact = record["all_paths"]
        interval = (
            f"{exact['low']:.4g} to {exact['high']:.4g} (Clopper and Pearson); valid for a budget "
            "fixed before the run, not given that the answer is undecided"
        )
        facts.append(("all paths", interval))
    return facts


def _limits(record: Mapping[str, Any]) -> str:
    """How many of the good paths broke a limit of the URDF."""
    if record["specification"]["limits"]:
        return ", none of which broke a limit of the URDF"
    return f", of which {record['broke_limits']:,} broke a limit of the URDF"


def _requirement(required: Mapping[str, Any]) -> str:
    """A specification in words."""
    words = [f"settles to {required['errors']} within {required['within']:g} s"]
    for name, label in (("effort", "|u|"), ("torque_rate", "torque rate")):
        if required[name] is not None:
            words.append(f"{label} at most {np.array2string(np.asarray(required[name]))}")
    return f"{', '.join(words)}, by a share of {required['share']:g} of all runs"
