"""The lowest versions that pyproject.toml allows, as a file of constraints for pip."""

import pathlib
import tomllib

project = tomllib.loads(pathlib.Path("pyproject.toml").read_text("utf-8"))["project"]
for requirement in sum(project["optional-dependencies"].values(), project["dependencies"]):
    name, lowest = requirement.split(">=")
    print(f"{name}=={lowest}")
