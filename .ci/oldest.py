"""The lowest versions that pyproject.toml allows, as a file of constraints for pip."""

import pathlib
import tomllib

project = tomllib.loads(pathlib.Path("pyproject.toml").read_text("utf-8"))["project"]
extras = project["optional-dependencies"].values()
for requirement in (*project["dependencies"], *(each for extra in extras for each in extra)):
    name, lowest = requirement.split(">=")
    print(f"{name}=={lowest}")
