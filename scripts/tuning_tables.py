"""Tables of README about tuned gains, from the records of fair_comparison and tune_arms."""

from typing import Any

from records import record, table

LAWS = {
    "FTCF": "FTCF, bias compensated",
    "FTCF, no compensation": "FTCF as the paper has it, no compensation",
    "CommandFilteredBackstepping": "command-filtered backstepping",
    "FiniteTimeBackstepping": "finite-time backstepping, regularised",
    "ComputedTorque": "computed torque (*is* stochastic backstepping)",
    "PDGravity": "PD with gravity compensation",
    "PositionFeedback": "positions alone",
    "SlotineLi": "Slotine and Li's adaptive law",
    "SuperTwisting": "super-twisting",
}
CELLS = (
    ("still", "ideal"), ("still", "fr3"), ("truck", "ideal"), ("truck", "fr3"),
    ("truck, accelerometer", "ideal"), ("truck, accelerometer", "fr3"),
)  # fmt: skip
ARMS = ("panda", "ur5", "xarm7", "so101", "talos_left_arm", "double_pendulum")


def mrad(x: float | None) -> str:
    """An error in milliradian, with three figures."""
    if x is None or x > 1.0:
        return "lost"
    return f"{1e3 * x:.2g}" if x < 0.1 else f"{1e3 * x:.0f}"


def fair() -> str:
    """Error of the worst 5 % of all laws, tuned alike."""
    cells = record("fair-comparison")["cells"]
    found = {(it["law"], it["environment"], it["hardware"]): it for it in cells}
    heads = ["law", *(f"{environment}, {hardware}" for environment, hardware in CELLS)]
    rows = [
        [words, *(_error(found[law, environment, hardware]) for environment, hardware in CELLS)]
        for law, words in LAWS.items()
    ]
    return table(heads, rows)


def _error(it: dict[str, Any]) -> str:
    failed = it["tuned"]["failed"]
    lost = f", {failed:.1%} failed" if failed else ""
    return f"{mrad(it['tuned']['late_rms_error'][1])} mrad{lost}"


def tuned_arms() -> str:
    """The paper's gains, the suggested and the tuned ones."""
    cases = record("tuned-arms")
    found = {(it["arm"], it["environment"], it["hardware"]): it for it in cases}
    rows = [
        [
            arm, f"{environment}, {hardware}",
            *(_row(it["rows"].get(name)) for name in ("paper", "suggested", "tuned")),
            f"{it['seconds']:.0f} s",
        ]
        for (arm, environment, hardware), it in found.items()
        if arm in ARMS and environment != "ship"
    ]  # fmt: skip
    heads = ["arm", "base, hardware", "the paper's gains", "suggested", "tuned", "tuned in"]
    return table(heads, sorted(rows, key=lambda row: ARMS.index(row[0])))


def _row(row: dict[str, Any] | None) -> str:
    if row is None:
        return "the same"
    error, rate = row["late_rms_error"], row["rms_torque_rate"]["median"]
    if error["median"] is None or error["median"] > 1.0:
        return "lost"
    speed = "" if rate is None else f", {rate:,.0f} N m/s"
    return f"{mrad(error['median'])} ({mrad(error['q95'])}) mrad{speed}"


if __name__ == "__main__":
    print(fair(), tuned_arms(), sep="\n\n")
