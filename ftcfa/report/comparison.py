"""A comparison as plain data, and the files of ``ftcfa compare``."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from ftcfa.report.comparison_figure import comparison_figure
from ftcfa.report.figures import rendered
from ftcfa.report.records import finite, interval, summary_file
from ftcfa.study.metrics.compared import COMPARED


def comparison_record(dataset: xr.Dataset) -> dict[str, Any]:
    """Content of summary.json: a row a loop, with intervals and differences from the first.

    Args:
        dataset: Result of `ftcfa.compare`.
    """
    rows = []
    for loop in dataset["loop"].values:
        one = dataset.sel(loop=loop)
        metrics = {
            name: {
                "unit": metric.unit,
                "mean": interval(one["mean"].sel(metric=name).values),
                "quantiles": [finite(x) for x in one["quantiles"].sel(metric=name).values],
                "difference": interval(one["difference"].sel(metric=name).values),
                "significant": bool(one["significant"].sel(metric=name)),
            }
            for name, metric in COMPARED.items()
        }
        rows.append(
            {
                "loop": str(loop),
                "differs in": str(one["differs"].values),
                "settled": int(one["settled"]),
                "diverged": int(one["diverged"]),
                "metrics": metrics,
            }
        )
    return {
        **dataset.attrs,
        "paths": dataset.sizes["path"],
        "compared with": str(dataset["loop"].values[0]),
        "quantiles": dataset["quantile"].values.tolist(),
        "loops": rows,
    }


def comparison_files(
    dataset: xr.Dataset, record: Mapping[str, Any], title: str
) -> dict[str, bytes]:
    """Files of ``ftcfa compare``, by name: PNG and SVG of the figure, and summary.json.

    Args:
        dataset: Result of `ftcfa.compare`.
        record: Result of `comparison_record`.
        title: Heading of the figure.
    """
    figure = rendered(comparison_figure(dataset, title))
    images = {f"comparison.{suffix}": content for suffix, content in figure.items()}
    return {**images, "summary.json": summary_file(record)}
