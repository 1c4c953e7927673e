"""Names of the pages of `fastdyn.derive.pages`, listed without SymPy."""

import pathlib

import fastdyn

PAGES = sorted(
    path.stem for path in pathlib.Path(fastdyn.__file__).with_name("derive").glob("pages/[a-z]*.py")
)
