"""pyproject.toml declares the imports of the package, and the versions that are run and named."""

import importlib.metadata
import pathlib
import re
import subprocess
import sys
import tomllib

from support.parsed import parsed

ROOT = pathlib.Path(__file__).parents[1]
DECLARED = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PROJECT = DECLARED["project"]
EXTRAS = PROJECT["optional-dependencies"].values()
OF_USERS = [*PROJECT["dependencies"], *(each for extra in EXTRAS for each in extra)]
BY_OTHERS = {"PIL"}  # of matplotlib


def text(name):
    return (ROOT / name).read_text("utf-8")


def test_what_is_imported_is_declared():
    found = set()
    for path in (*(ROOT / "fastdyn").rglob("*.py"), *(ROOT / "kernels").rglob("*.py")):
        found |= parsed(path).imported
    known = {re.match(r"[\w-]+", each)[0].lower().replace("-", "_") for each in OF_USERS}
    assert found - known - set(sys.stdlib_module_names) - {"fastdyn"} - BY_OTHERS == set()
    assert not {"matplotlib", "tqdm"} & found  # they are imported by `needed` alone


def test_the_lowest_versions_are_those_that_are_declared():
    done = subprocess.run(
        [sys.executable, ".ci/oldest.py"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == [each.replace(">=", "==") for each in OF_USERS]


def test_the_archives_are_built_by_the_oldest_setuptools_allowed():
    (lowest,) = DECLARED["build-system"]["requires"]
    assert lowest.replace(">=", "==") in DECLARED["dependency-groups"]["release"]


def test_the_lowest_python_is_the_first_that_is_named():
    named = re.findall(r":: (3\.\d+)", "\n".join(PROJECT["classifiers"]))
    assert named[0] == PROJECT["requires-python"].removeprefix(">=")


def test_the_version_of_the_package_is_that_of_all_files():
    import fastdyn

    assert importlib.metadata.version("fastdyn") == fastdyn.__version__
    files = [*(ROOT / "fastdyn").rglob("*.py"), *(ROOT / ".ci").iterdir(), ROOT / "pyproject.toml"]
    named = {path.name for path in files if f'"{fastdyn.__version__}"' in path.read_text("utf-8")}
    assert named == {"__init__.py"}
    assert (
        re.search(r"^version: (\S+)$", text("CITATION.cff"), re.MULTILINE)[1] == fastdyn.__version__
    )
    assert re.search(r"^date-released: \d{4}-\d\d-\d\d$", text("CITATION.cff"), re.MULTILINE)
    assert re.search(r"^## (\S+) \(", text("CHANGELOG.md"), re.MULTILINE)[1] == fastdyn.__version__


def test_the_changelog_is_one_page():
    assert len(text("CHANGELOG.md").splitlines()) < 160


def test_the_checkout_imports_in_its_folder():
    """After `pip install .`, too: Python looks first into the folder where the README lies."""
    script = (
        "import sys; sys.meta_path = [f for f in sys.meta_path if 'editable' not in repr(f)]\n"
        "import fastdyn; print(fastdyn.kernels.__path__[0])"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert pathlib.Path(done.stdout.strip()) == ROOT / "kernels"
