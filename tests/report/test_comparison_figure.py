"""The figure of a comparison: all that its note says is on the page."""

import numpy as np
import xarray as xr

from ftcfa.report.comparison_figure import PANELS, comparison_figure
from ftcfa.report.figures import rendered


def test_the_note_of_many_failures_fits_the_page():
    names = [f"a law with a long name {k}" for k in range(8)]
    quantiles = np.tile(np.geomspace(1e-3, 1.0, 5), (len(names), len(PANELS), 1))
    dataset = xr.Dataset(
        {
            "quantiles": (("loop", "metric", "quantile"), quantiles),
            "kept": ("loop", np.full(len(names), 7)),
            "diverged": ("loop", np.full(len(names), 1)),
        },
        coords={"loop": names, "metric": list(PANELS), "path": np.arange(10)},
        attrs={"duration": 5.0},
    )
    figure = comparison_figure(dataset, "many laws")
    rendered(figure)  # lays it out
    note = next(text for text in figure.texts if text.get_text().startswith("median"))
    words = " ".join(note.get_text().split())
    assert all(f"{name}: 3" in words and f"{name}: 1" in words for name in names)
    box, page = note.get_window_extent(), figure.bbox
    assert page.x0 <= box.x0
    assert box.x1 <= page.x1
    assert page.y0 <= box.y0
