"""The numbers in README.md and ftcfa/README.md, from the records that the scripts write.

    python scripts/readme.py [--run]

Between ``<!-- NAME -->`` and ``<!-- end -->`` stands what the function of that name here makes of
the records in scripts/figures. With --run all scripts first draw their figures and write their
records anew, which takes fifteen minutes; a test compares both with the records.
"""

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import ftcfa
from ftcfa.study.reproduction import FINITE_TIME, closed_loop

sys.path.insert(0, str(Path(__file__).parent))
from hardware_tables import bases, margins, velocities, whole_band
from records import FIGURES, record, table
from tuning_tables import fair, tuned_arms

SCRIPTS = Path(__file__).parent
ROOT = SCRIPTS.parent
RUN = (
    "compare_laws", "basin", "all_arms", "truck_floor", "ensemble_paper", "generator",
    "rival_singularity", "filters", "velocities", "margins", "sensors_and_motors",
    "fair_comparison", "which_gains_matter", "tune_arms", "gradients",
    "coverage_table", "kernel_accuracy",
)  # fmt: skip
"""The scripts, each with its option --out."""
LAWS = {
    "as given, printed": "FTCF as the paper has it, as printed",
    "as given": "the same, anti-saturation bounded",
    "FTCF-printed": "FTCF, bias compensated, as printed",
    "FTCF": "the same, anti-saturation bounded (the default)",
    "FTCF-asymptotic": "the same, κ = 1",
    "CommandFilteredBackstepping": "command-filtered backstepping, second-order filter",
    "StochasticBackstepping": "stochastic backstepping (*is* computed torque)",
    "ComputedTorque": "computed torque",
    "FiniteTimeBackstepping": "finite-time backstepping, no filter (singular)",
    "FiniteTimeBackstepping-regularised": "the same, regularised",
    "PDGravity": "PD with gravity compensation",
    "PositionFeedback": "positions alone (linear-quadratic-Gaussian)",
    "SlotineLi": "Slotine and Li's adaptive law",
    "SlotineLi, adaptation off": "the same, adaptation off",
    "SuperTwisting": "super-twisting",
}
"""Rows of the table of rivals: name in the record, and in README."""
ABLATIONS = {
    "as given": "as given",
    "without error compensation": "without error compensation",
    "without the anti-saturation state": "without the anti-saturation state",
    "without the network": "without the network",
    "with the second-order filter": "with the second-order filter",
    "kappa = 1": "κ = 1",
}
"""Rows of the table of ablations."""
FREE, HELD = ("rms_torque_rate",), ("rate_limited", "failed")
"""What the table of rivals says of Panda beside its error, with ideal hardware and with fr3."""
LOW, MIDDLE, HIGH = 0, 2, 4
"""Places of 5, 50 and 95 % among the quantiles of a comparison."""


def reproduction() -> str:
    """Caption of figure 2."""
    finite, asymptotic = (f"{case['rms_ote']:.3f}" for case in record("reproduction")["cases"][:2])
    return (
        "*The study of Song, Zhao and Cui, reproduced on a URDF: the shaken double pendulum "
        f"follows its reference with an rms error of {finite} rad under the finite-time law "
        f"(κ = 0.6) and of {asymptotic} rad under the asymptotic law (κ = 1), both as printed, "
        "with noise as printed (Σ = 0.1). κ is the fractional power of the law: it feeds back "
        "sign(x)|x|^κ.*"
    )


def truck() -> str:
    """Caption of truck-floor.png."""
    found = record("truck-floor")
    cases = {(c["arm"], c["compensation"], c["floor"], c["uncertain"]): c for c in found["cases"]}
    panda, robots, rest, lines = (
        cases["Panda", "bias", *which]["rms_error"]
        for which in (("truck", False), ("truck", True), ("at rest", False), ("lines", False))
    )
    sag = cases["Panda", "none", "truck", False]["rms_error"]
    pendulum, still = (
        cases["pendulum", "none", floor, False]["rms_error"] for floor in ("truck", "at rest")
    )
    heavy = cases["pendulum", "none", "truck", True]
    lost = sum(case["lost"] for case in found["cases"])
    return (
        "*`python scripts/truck_floor.py`: both arms on the floor of a highway truck, with the "
        f"paper's gains, {found['paths']} paths. Panda's rms error is {panda[1]:.1f} mrad (median; "
        f"5 to 95 %: {panda[0]:.1f} to {panda[2]:.1f}), against {rest[1]:.3f} mrad on a floor at "
        f"rest. It is {robots[1]:.1f} mrad ({robots[0]:.1f} to {robots[2]:.1f}) where each path "
        "has its own robot: masses spread by 20 %, centres of mass by 1 cm, shapes by 10 %. "
        f"Without compensation Panda sags by {sag[1]:.0f} mrad. The pendulum's rms error is "
        f"{pendulum[1]:.1f} mrad ({still[1]:.1f} at rest). But {heavy['heavy']} of its "
        f"{found['paths']} uncertain robots are too heavy to follow the reference with 15 N m even "
        f"at rest; their error reaches {heavy['largest_error']:.1f} rad. "
        f"{lost or 'No'} path{'s' if lost > 1 else ''} lost track.*\n\n"
        "A filter passes some power outside the band of its table: 3 % of the truck's variance. "
        "The part below 10 Hz moves an arm most. `RandomPhase` has no power there; with it Panda's "
        f"rms error is {lines[1]:.1f} mrad instead of {panda[1]:.1f}."
    )


def ensembles() -> str:
    """Caption of ensemble.png."""
    found = record("ensemble")
    finite, asymptotic = found["κ = 0.6"], found["κ = 1"]
    square, other = finite["mean_square"], asymptotic["mean_square"]
    paths = f"{found['paths']:,}"
    return (
        f"*`python scripts/ensemble_paper.py`: the paper's comparison on {paths} paths, law and "
        f"noise (Σ = 0.1) as printed. With κ = 0.6 {finite['settled']:,} settle to 0.05 rad, in "
        f"{finite['median']:.3f} s (median). With κ = 1 only {asymptotic['settled']} do: the paper "
        "compensates no gravity, and this law cannot hold it. The mean-square errors, "
        f"{square[0]:.3e} ({square[1]:.3e} to {square[2]:.3e}) and {other[0]:.4e} rad² "
        f"({other[1]:.4e} to {other[2]:.4e}), differ by a factor of {other[0] / square[0]:.0f}.*"
    )


def rivals() -> str:
    """Table of the laws on both arms."""
    found = record("compare-laws")
    arms = ("pendulum", "panda", "panda-fr3")
    pendulum, panda, limited = (found[arm]["rivals"]["loops"] for arm in arms)
    heads = [
        "law", "pendulum: rms error", "settled", "torque rate", "saturated",
        "Panda, ideal: rms error (5 to 95 %)", "torque rate", "Panda, fr3: rms error (5 to 95 %)",
        "rate limited", "fail",
    ]  # fmt: skip
    rows = [
        [label, *_pendulum(pendulum[law]), *_panda(panda, law, FREE), *_panda(limited, law, HELD)]
        for law, label in LAWS.items()
        if law in pendulum
    ]
    return table(heads, rows)


def _pendulum(loop: dict[str, Any]) -> list[str]:
    mean = {name: metric["mean"]["estimate"] for name, metric in loop.items()}
    return [
        f"{1e3 * mean['late_rms_error']:.3g} mrad",
        f"{loop['settling_time']['quantiles'][MIDDLE]:.3f} s",
        f"{mean['torque_rate']:.3g} /s",
        f"{100 * mean['saturated']:.1f} %",
    ]


def _panda(loops: dict[str, Any], law: str, more: tuple[str, ...]) -> list[str]:
    """Cells of Panda, whose loop as given has its bias compensated; shares are means."""
    if law in ("as given", "as given, printed"):
        return [""] * (1 + len(more))
    loop = loops.get(law, loops["as given"])
    quantiles = [1e3 * q for q in loop["late_rms_error"]["quantiles"]]
    cells = {
        "rms_torque_rate": f"{loop['rms_torque_rate']['quantiles'][MIDDLE]:,.0f} N m/s",
        "rate_limited": f"{100 * loop['rate_limited']['mean']['estimate']:.0f} %",
        "failed": f"{100 * loop['failed']['mean']['estimate']:.1f} %",
    }
    return [
        f"{quantiles[MIDDLE]:.1f} mrad ({quantiles[LOW]:.1f} to {quantiles[HIGH]:,.1f})",
        *(cells[name] for name in more),
    ]


def ablations() -> str:
    """Table of the law as printed less an ingredient."""
    found = record("compare-laws")
    both = [found[arm]["ablations of the law as printed"]["loops"] for arm in ("pendulum", "panda")]
    rows = []
    for name, label in ABLATIONS.items():
        pendulum, panda = (loops[name] for loops in both)
        errors = (1e3 * one["late_rms_error"]["mean"]["estimate"] for one in (pendulum, panda))
        first, second = (f"{error:.3g} mrad" for error in errors)
        settled = pendulum["settling_time"]["quantiles"][MIDDLE]
        rows.append([label, first, f"{settled:.3f} s", second])
    heads = ["FTCF as printed, less an ingredient", "pendulum: rms error", "settled",
             "Panda: rms error"]  # fmt: skip
    return table(heads, rows)


def singularity() -> str:
    """What the exact law demands as the period shrinks."""
    found = record("rival-singularity")
    periods, medians = found["periods"], found["medians"]["pendulum"]
    exact, filtered = medians["FiniteTimeBackstepping"], medians["FTCF"]
    return (
        "`scripts/rival_singularity.py` shows why the law has a command filter. Without one, the "
        f"largest commanded torque of a path on the pendulum (noise 0.1, psd) grows as the period "
        f"shrinks, from {exact[0]:.0f} N m at {periods[0]:g} ms to {exact[-1]:.0f} N m at "
        f"{periods[-1]:g} ms (medians), and to thousands in single paths. FTCF commands "
        f"{filtered[-1]:.0f} N m at any period. `scripts/filters.py` compares the filters "
        "(implicit, explicit, second-order, proper) for different steps and noise levels."
    )


def theorem() -> str:
    """The constants of Theorem 1 for the paper's study."""
    promised = ftcfa.bounds(closed_loop(FINITE_TIME))
    return (
        "`ftcfa bounds` computes the constants of the repaired Theorem 1 for any arm. It also says "
        "which printed inequality each repair replaces, which term makes the bound large and which "
        f"premise the paths break. For the paper's study Δ = {promised.Delta:.4g}, Γ = "
        f"{promised.Gamma:.3g}, and the tracking error z1 = q - q_d keeps |z1| ≤ "
        f"{promised.ultimate_error:.3g} rad wherever the Lyapunov function V is at most its "
        "ultimate level. This bound is correct but too large to be useful: it is "
        f"{promised.error_without_largest_term:.3g} rad without the saturation term, and the "
        "simulated error is 0.003 rad."
    )


def generator() -> str:
    """Caption of generator.png."""
    found = record("generator")
    return (
        "*`python scripts/generator.py`: along the paths of the study (law and noise as printed) "
        "E[LV] stays below the bound. The bound of the first-entry time is finite for a hanging "
        f"link with 3 N m: {found['promised_entry']:.2f} s, where {found['paths']:,} paths take "
        f"{found['entry']:.3f} s in the mean. With the paper's gains no start was found for which "
        "it is finite.*"
    )


def basin() -> str:
    """Where the law as printed runs away, and what the default does instead."""
    found = record("basin")
    start, far, bounded = found["premises"].values()
    rows = [
        [name, f"{arm['paths']:,}", *(f"{share:.1f}" for share in arm["lost"].values()),
         f"{arm['excess']['bounded'][0]:+.2f} ({arm['excess']['bounded'][1]:+.2f})"]
        for name, arm in found["arms"].items()
        if max(arm["lost"].values()) > 0.0
    ]  # fmt: skip
    none = ", ".join(n for n, arm in found["arms"].items() if max(arm["lost"].values()) == 0.0)
    heads = [
        "arm, % of paths lost", "paths", "`none`", "`bounded`", "`paper`",
        "bounded over none (at most)",
    ]  # fmt: skip
    premises = (
        "*Which premise breaks.* From the paper's start the command filter's error "
        "|abar - alpha| is "
        f"{start['filter_error']:.2g} rad/s at most and {start['late_filter_error']:.1g} after 1 s "
        "(Lemma 7 calls its bound π1). From (1, 1) under (11) as printed it is "
        f"{far['filter_error']:.2g} and still {far['late_filter_error']:.2g} after 1 s, rho "
        f"reaches {far['largest_rho']:,.0f} rad/s, and the network's input reaches "
        f"{far['largest_input']:.0f}, far outside the compact set of Lemma 1 (its centres lie "
        f"within ±2). With the bounded gap π1 is {bounded['filter_error']:.2g} and rho "
        f"{bounded['largest_rho']:.2g}."
    )
    kept = f"(No path is lost, whatever the anti-saturation, on {none}.)"
    return f"{table(heads, rows)}\n\n{kept}\n\n{premises}"


def arms() -> str:
    """How well FTCF holds the arms of the catalogue."""
    found = record("all-arms")
    error = {name: row["rms_error"] for name, row in found["arms"].items()}
    large = ("panda", "ur5", "xarm7", "kinova", "talos_left_arm", "baxter")
    small = ("so101", "so100", "asr_twodof", "finger_edu")
    relative = found["arms"]["double_pendulum_relative"]

    def listed(names: tuple[str, ...]) -> str:
        return ", ".join(f"{name} {error[name]:.3f}" for name in names)

    return (
        '`python scripts/all_arms.py`: with the paper\'s gains, `compensation="bias"` and white '
        "base noise of intensity 0.1 (psd), the larger arms follow home + 0.3 sin t with at most "
        f"0.01 rad rms ({listed(large)}; means of {found['paths']} paths). The small arms do not: "
        "on links of 0.1 m a base acceleration causes ten times as much joint acceleration "
        f"({listed(small)}). A larger c2 helps (so101 with c2 = 100: "
        f"{error['so101, c2 = 100']:.3f}). The double pendulum in relative angles loses track in "
        f"{relative['lost_track'] + relative['diverged']} of {found['paths']} paths, under any "
        "anti-saturation: its torque at home is too small for this motion."
    )


def coverage() -> str:
    """How often the intervals cover."""
    found = record("coverage")
    rows = [
        [interval, *(" / ".join(f"{100 * x:.1f}" for x in row[name]) for name in row)]
        for interval, row in found["coverage"].items()
    ]
    sizes = " / ".join(map(str, found["sizes"]))
    heads = [f"% of {found['ensembles']:,} ensembles of {sizes} paths", *_first(found["coverage"])]
    return table(heads, rows)


def accuracy() -> str:
    """Errors of the elementary functions."""
    found = record("kernel-accuracy")
    errors = ", ".join(f"{name} {error:.2f}" for name, error in found["ulp"].items())
    return (
        f"Largest error in units in the last place, over {found['numbers']:,} numbers of each kind "
        f"(kernels {found['kernels']}, `scripts/kernel_accuracy.py`): {errors}."
    )


def machines() -> str:
    """The loops that have one hash on every machine."""
    found = record("machines")
    names, loops = list(found["machines"]), found["machines"]["8 lanes"]
    assert found["same"]
    assert len(found["stores"]) == 2
    hashes = table(["loop", "hash"], [[name, f"`{digest}`"] for name, digest in loops.items()])
    return (
        f"{hashes}\n\n{found['seconds']:g} s of each loop have this one hash on {len(names)} "
        f"machines: {', '.join(names)}. An ensemble of uncertain Pandas that was begun with 8 "
        "lanes, killed, gone on with by 4 lanes, killed and finished on aarch64 is identical to "
        "one that was not interrupted."
    )


def _first(rows: dict[str, dict[str, Any]]) -> list[str]:
    """The columns of a table of rows."""
    return list(next(iter(rows.values())))


SECTIONS = {"README.md": (
    reproduction, truck, ensembles, rivals, bases, whole_band, velocities, margins, ablations,
    singularity, theorem, generator, basin, arms, tuned_arms, fair,
), "ftcfa/README.md": (coverage, accuracy, machines)}  # fmt: skip
"""The functions that write a section of a file, each under its name."""


def rewritten(file: str) -> str:
    """The text of a file with its sections written anew."""
    text = (ROOT / file).read_text()
    for section in SECTIONS[file]:
        name = section.__name__
        pattern = rf"(<!-- {name} -->\n).*?(\n<!-- end -->)"
        text, count = re.subn(
            pattern, lambda m, s=section: f"{m[1]}{s()}{m[2]}", text, flags=re.DOTALL
        )
        assert count == 1, f"{file} has {count} sections {name}"
    return text


def run_scripts() -> None:
    """Draw all figures and write all records anew."""
    for script in RUN:
        print(script, flush=True)
        subprocess.run([sys.executable, SCRIPTS / f"{script}.py", "--out", FIGURES], check=True)
    reproduced = ROOT / "out" / "reproduction"
    subprocess.run([sys.executable, "-m", "ftcfa", "reproduce", "--out", reproduced], check=True)
    shutil.copy(reproduced / "figure-2.png", FIGURES / "figure-2.png")
    shutil.copy(reproduced / "summary.json", FIGURES / "reproduction.json")


def main() -> None:
    """Write the files anew."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", action="store_true", help="run all scripts first: ten minutes")
    if parser.parse_args().run:
        run_scripts()
    for file in SECTIONS:
        (ROOT / file).write_text(rewritten(file))


if __name__ == "__main__":
    main()
