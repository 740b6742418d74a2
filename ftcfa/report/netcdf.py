"""A Dataset as a netCDF file."""

import xarray as xr

INT32 = 2**31
"""Integer attributes of a netCDF file must be smaller."""


def netcdf(dataset: xr.Dataset) -> bytes:
    """Content of a netCDF-3 file, which every tool reads, with a Dataset.

    Integers are stored with 32 bits; a seed that does not fit is written as text.
    """
    large = {
        name: str(value)
        for name, value in dataset.attrs.items()
        if isinstance(value, int) and value >= INT32
    }
    return bytes(dataset.assign_attrs(large).to_netcdf(engine="scipy"))
