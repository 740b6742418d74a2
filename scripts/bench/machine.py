"""The machine on which the benchmark runs, and its versions."""

import os
import platform
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from rich.console import Console
from timing import Record

from ftcfa.engine.compiled import usable_cores
from ftcfa.engine.compiler.kernels.table import KERNELS
from ftcfa.engine.compiler.target import host_target

PACKAGES = ("ftcfa", "pin", "casadi", "llvmlite", "numpy", "mujoco", "jax", "jaxlib", "diffrax")


def machine() -> Record:
    """Processor, load, system and versions; None for a package that is not installed."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = None
    target = host_target()
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "cpu": _cpu_name(),
        "cores": usable_cores(),
        "lanes": target.lanes,
        "kernels": KERNELS,
        "load_before": os.getloadavg()[0],
        "system": platform.platform(),
        "python": platform.python_version(),
        "versions": versions,
    }


def print_machine(host: Record, console: Console) -> None:
    """Print the machine and the versions."""
    versions = ", ".join(f"{name} {v}" for name, v in host["versions"].items() if v)
    console.print(
        f"{host['date']}  {host['cpu']}, {host['cores']} cores, {host['lanes']} lanes, "
        f"kernels {host['kernels']}, load {host['load_before']:.1f} before\n{versions}",
        highlight=False,
        soft_wrap=True,
    )


def _cpu_name() -> str:
    """Name of the processor."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
