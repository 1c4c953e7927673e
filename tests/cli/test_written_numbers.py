"""Files hold numbers as a person would write them."""

import math

import numpy as np
import pytest

from bench.__main__ import rounded
from fastdyn.cli.main import main
from fastdyn.words import numbers


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (1.0, "1"), (0.1, "0.1"), (1e-6, "1e-6"), (-2.5e-7, "-2.5e-7"),
        (1e22, "1e+22"), (1 / 3, "0.3333333333333333"), (math.nan, ""), (math.inf, ""),
        (np.float32(0.5), "0.5"), (7, "7"), (0.1 + 0.2, "0.30000000000000004"),
    ],
)  # fmt: skip
def test_a_computed_number_has_the_fewest_digits_that_give_it(value, text):
    assert numbers.computed(value) == text
    assert not text or float(text) == value


def test_a_number_of_a_grid_is_its_decimal():
    grid = [numbers.chosen(value) for value in np.linspace(0.0, 20.0, 201)]
    assert grid == [f"{i / 10:g}" for i in range(201)]
    third = math.pi / 18  # no decimal number: all of its digits
    assert numbers.chosen(third) == repr(third) and numbers.chosen(math.nan) == ""


@pytest.mark.parametrize("value", [1e-6, 0.02, 20.0, -1e-300, 5, None, "RK4", [0.5, 1e-5]])
def test_source_text_gives_the_value(value):
    assert eval(numbers.source(value)) == value
    assert numbers.source(1e-6) == "1e-6" and numbers.source(20.0) == "20.0"


@pytest.mark.parametrize(
    ("words", "first"),
    [
        ("run pendulum --t-end 1 --points 11", [f"{i / 10:g}" for i in range(11)]),
        ("sweep tower --h 1:2:11", [f"{i / 10:g}" for i in range(10, 21)]),
    ],
)
def test_a_table_is_short_and_gives_the_same_numbers(words, first, tmp_path):
    path = tmp_path / "table.csv"
    assert main([*words.split(), "--csv", str(path)]) == 0
    head, *rows = [line.split(",") for line in path.read_text().splitlines()]
    assert [row[0] for row in rows] == first
    for cell in (cell for row in rows for cell in row[1:]):
        assert cell == numbers.computed(float(cell)) and len(head) == len(rows[0])


def test_records_of_benchmarks_have_the_digits_of_a_measurement():
    record = {"seconds": [73.43681107000157, 1e-9 / 3], "n": 123456789, "name": "x", "none": None}
    kept = {"seconds": [73.4368, 3.33333e-10], "n": 123456789, "name": "x", "none": None}
    assert rounded(record) == kept
