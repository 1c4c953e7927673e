"""The house is in order: short files, short functions, few parameters."""

import collections
import pathlib
import re

import pytest

from support.parsed import parsed

ROOT = pathlib.Path(__file__).parents[1]
FILES = [p for d in ("fastdyn", "kernels", "tests", "bench") for p in (ROOT / d).rglob("*.py")]
LINES, BODY, PARAMETERS, FILES_A_FOLDER = 400, 66, 10, 15
REGISTRIES = {"fastdyn/derive/pages", "kernels/methods"}  # each file is an entry
DOORS = {"jax.py", "torch.py", "pytensor.py"}  # of other libraries: a file each, by its name
SEVERAL = 2.18  # percent of assignments that are several on one line
WIDE = 204  # lines of code in the documentation that have more than 80 columns
MANY = {"solve_ensemble", "solve_dae_ensemble", "energy_drift", "solve_bvp", "problem"}
MANY |= {"solve_sde", "solve_langevin", "odeint", "solve_dde_ensemble"}


def test_files_and_functions_are_short():
    assert len(FILES) > 200
    assert [path for path in FILES if parsed(path).lines > LINES] == []
    found = [(path.name, f) for path in FILES for f in parsed(path).functions]
    assert [each for each in found if each[1].body > BODY] == []


@pytest.mark.parametrize("folder", ["fastdyn", "kernels"])
def test_functions_have_few_parameters(folder):
    found = [f for path in (ROOT / folder).rglob("*.py") for f in parsed(path).functions]
    assert len(found) > 100
    many = {f.name for f in found if f.n_parameters > PARAMETERS}
    assert many <= MANY


def test_folders_can_be_taken_in():
    for folder, most in (("fastdyn", 28), ("kernels", 12)):
        markers = {"__pycache__", "py.typed"}  # nothing to take in
        names = {p.name for p in (ROOT / folder).iterdir()} - markers - DOORS
        assert len(names) <= most, sorted(names)
    counts = collections.Counter(
        path.parent.relative_to(ROOT).as_posix()
        for path in FILES
        if path.parts[len(ROOT.parts)] in ("fastdyn", "kernels") and path.name != "__init__.py"
    )
    assert {folder for folder, n in counts.items() if n > FILES_A_FOLDER} <= REGISTRIES


def test_files_that_comments_and_the_guide_name_exist():
    named = re.compile(r"\b[a-z]\w*(?:/\w+)*/\w+\.(?:py|md)\b")
    there = [
        path.relative_to(ROOT) for path in (*FILES, *ROOT.glob("*.md"), *ROOT.glob("[bd]*/**/*.md"))
    ]
    ends = {"/".join(path.parts[i:]) for path in there for i in range(len(path.parts))}
    texts = [path for path in FILES if "tests" not in path.parts]
    for text in (*texts, ROOT / "docs" / "developing.md"):
        names = named.findall(text.read_text())
        missing = {name for name in names if not {name, name.removeprefix("fastdyn/")} & ends}
        assert missing <= {"kernels/methods/NAME.py"}, text


def test_every_folder_is_a_package():
    """So setup.py finds the folder; `.ci/check_wheel` lists what a wheel then holds."""
    folders = {path.parent for path in FILES if path.is_relative_to(ROOT / "fastdyn")}
    folders |= {path.parent for path in FILES if path.is_relative_to(ROOT / "kernels")}
    assert [folder for folder in folders if not (folder / "__init__.py").exists()] == []


def test_each_file_that_builds_llvm_says_why():
    built = re.compile(r"llvmlite|import intrinsic|lower_constant")
    files = [*(ROOT / "kernels").rglob("*.py"), *(ROOT / "fastdyn/specialise").glob("*.py")]
    texts = {path: path.read_text() for path in files}
    found = [path for path, text in texts.items() if built.search(text)]
    assert len(found) > 10
    assert [path for path in found if "LLVM, because" not in texts[path]] == []


def test_ever_fewer_assignments_are_several_on_one_line():
    """One assignment a statement, but for swaps and the unpacking of one value.

    The share may only fall.  Whoever has separated some runs this test, and writes the share that
    the message names into SEVERAL.
    """
    paths = [path for folder in ("fastdyn", "kernels") for path in (ROOT / folder).rglob("*.py")]
    n_assignments = sum(parsed(path).n_assignments for path in paths)
    share = 100 * sum(parsed(path).n_several for path in paths) / n_assignments
    assert n_assignments > 10_000
    assert share <= SEVERAL, f"{share:.2f} % of the assignments put a tuple into a tuple"
    assert share > SEVERAL - 1.0, f"the share has fallen: write {share + 0.01:.2f} into SEVERAL"


def test_ever_fewer_lines_of_documented_code_are_wide():
    """On a laptop 100 columns fit beside the contents, on tablets 80.  The number may only fall."""
    wide = []
    for page in (ROOT / "docs").rglob("*.md"):
        blocks = re.findall(r"^```.*?^```", page.read_text("utf-8"), re.DOTALL | re.MULTILINE)
        wide += [line for block in blocks for line in block.splitlines() if len(line) > 80]
    assert len(wide) <= WIDE, f"{len(wide)} lines have more than 80 columns"
