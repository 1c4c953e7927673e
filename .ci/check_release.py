"""List, check, install and try the archives of `make release`, away from the checkout."""

import ast
import collections
import os
import pathlib
import re
import subprocess
import sys
import tarfile
import tempfile
import time
import tomllib
import venv
import zipfile

ROOT = pathlib.Path(__file__).parents[1]
SOURCES = {  # what a distributor builds, tests and reads
    "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "Makefile", "README.md",
    "SECURITY.md", "pyproject.toml", "fastdyn/__init__.py", "kernels/methods/rk45.py",
    "tests/conftest.py", "tests/solve/test_scipy_suite.py", "docs/start.md", "bench/__main__.py",
}  # fmt: skip
NEVER = re.compile(r"__pycache__|\.py[co]$|\.venv|_cache/|\.o$|egg-info/.*\.git")
FIRST = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL)


def version():
    """The version, which fastdyn/__init__.py alone states."""
    for node in ast.parse((ROOT / "fastdyn/__init__.py").read_text("utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__version__":
            return ast.literal_eval(node.value)
    raise SystemExit("fastdyn/__init__.py has no __version__.")


def obstacles(number):
    """The reasons not to upload this version, as sentences."""
    first = re.search(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    heading = first[1] if first else "nothing"
    if not re.fullmatch(rf"{re.escape(number)} \(\d{{4}}-\d\d-\d\d\)", heading):
        yield f'CHANGELOG.md begins with "{heading}", not with "{number} (YYYY-MM-DD)".'
    urls = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["urls"]
    if any(".invalid" in url for url in urls.values()):
        yield "project.urls in pyproject.toml names places that do not exist."


def names(archive):
    """The files of an sdist, without the folder around them, or of a wheel."""
    if archive.suffix == ".whl":
        return set(zipfile.ZipFile(archive).namelist())
    with tarfile.open(archive) as tar:
        files = [member.name for member in tar.getmembers() if member.isfile()]
    return {name.partition("/")[2] for name in files}


def check(archive, number):
    """List what an archive holds, by folder; stop if something lacks or should not be there."""
    found = names(archive)
    folders = collections.Counter("/".join(name.split("/")[:-1][:3]) for name in found)
    print(f"\n{archive.name}: {archive.stat().st_size / 1e6:.2f} MB, {len(found)} files")
    for folder, count in sorted(folders.items()):
        print(f"  {count:5} {folder or '.'}")
    compiled = {name for name in found if name.endswith(".o")}
    wheel = archive.suffix == ".whl"
    pure = "none-any" in archive.name
    assert archive.name.startswith(f"fastdyn-{number}"), archive.name
    assert bool(compiled) == (wheel and not pure), f"{len(compiled)} kernels in {archive.name}"
    assert [name for name in found - compiled if NEVER.search(name)] == []
    if wheel:
        tops = {name.partition("/")[0] for name in found}
        assert tops == {"fastdyn", f"fastdyn-{number}.dist-info"}, tops
        assert "fastdyn/kernels/methods/facts.json" in found and "fastdyn/py.typed" in found
        assert {
            "fastdyn/trace/emit/source/helpers.c",
            "fastdyn/pages/assets/uplot/LICENSE",
        } <= found
    else:
        assert found >= SOURCES, SOURCES - found


def run(python, *words, folder):
    """The output and the seconds of a command that sees nothing of the checkout."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment = kept | {"NUMBA_CACHE_DIR": str(folder / "kept"), "FASTDYN_SHARED_CODE": ""}
    begin = time.perf_counter()
    done = subprocess.run(
        [python, *words], cwd=folder, env=environment, capture_output=True, text=True
    )
    if done.returncode:
        raise SystemExit(f"{words}: {done.stdout}{done.stderr}")
    return done.stdout, time.perf_counter() - begin


def attempt(archive, scratch):
    """Install an archive beside its dependencies; the README's first lines and a lesson."""
    folder = scratch / archive.name
    venv.create(folder / "venv", with_pip=True)
    python = str(folder / "venv" / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))
    run(python, "-m", "pip", "install", "--quiet", str(archive.resolve()), folder=folder)
    (folder / "first.py").write_text(FIRST[1], "utf-8")
    where = run(python, "-c", "import fastdyn; print(fastdyn.__file__)", folder=folder)[0]
    assert str(folder) in where, where
    for name in ("numpy", "fastdyn"):
        seconds = run(python, "-c", f"import {name}", folder=folder)[1]
        print(f"  a process that imports {name}: {seconds:.2f} s")
    for when in ("first", "second"):
        answer, seconds = run(python, "first.py", folder=folder)
        expected = re.search(r"# ([^#]*)$", FIRST[1])[1]
        assert answer == expected, (answer, expected)
        print(f"  the README's first lines, {when} process: {seconds:.2f} s, {answer.strip()}")
    words = ("-m", "fastdyn", "tour", "pendulum", "--out", "figures")
    said, seconds = run(python, *words, folder=folder)
    print(f"  fastdyn tour pendulum: {seconds:.1f} s, {re.search('.*checks passed', said)[0]}")
    assert list((folder / "figures").iterdir())


def main():
    number = version()
    archives = [pathlib.Path(name) for name in sys.argv[1:]]
    assert sum(archive.suffix == ".whl" for archive in archives) == 2 and len(archives) == 3
    for archive in archives:
        check(archive, number)
    with tempfile.TemporaryDirectory() as scratch:
        for archive in archives:
            print(f"\n{archive.name}, installed:")
            attempt(archive, pathlib.Path(scratch))
    print(f"\nfastdyn {number}: all archives install and solve.")
    print("\n".join(f"Not to be uploaded yet: {one}" for one in obstacles(number)))


main()
