"""Elementary functions as straight-line code: the same bits on every machine, without a libm."""
