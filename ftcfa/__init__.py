"""Robust control of robot arms whose base shakes at random.

The public names are listed in `__init__.pyi` and imported when they are first used, so that
``ftcfa --help`` does not wait for Pinocchio, CasADi and xarray.
"""

from importlib.metadata import version

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__version__ = version("ftcfa")
