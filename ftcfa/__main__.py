"""``python -m ftcfa``."""

from ftcfa.cli import main

main()
