#!/usr/bin/env python3
"""Draws the figures of docs/pictures that no scene gives, as SVG and PNG: draw.py FOLDER [NAME or pattern]"""

import fnmatch
import sys

import common
import design_figures  # noqa: F401
import paper_figures  # noqa: F401
import path_figures  # noqa: F401
import reproduction  # noqa: F401
import theory_figures  # noqa: F401

if len(sys.argv) not in (2, 3):
    sys.exit(__doc__)
names = fnmatch.filter(common.figures, sys.argv[2] if len(sys.argv) == 3 else "*")
if not names:
    sys.exit(f"draw.py: {sys.argv[2]}: no figure has this name; there are {', '.join(common.figures)}")
try:
    for file in common.write(sys.argv[1], names):
        print(file)
except OSError as error:
    sys.exit(f"draw.py: {error}; choose another folder")
