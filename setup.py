"""Every folder of fastdyn/ and of kernels/ is a package; pyproject.toml says all the rest.

`packages.find` of pyproject.toml cannot install kernels/ as fastdyn.kernels: a package gets the
name of its folder.
"""

from setuptools import find_packages, setup

kernels = ["fastdyn." + name for name in find_packages(include=["kernels", "kernels.*"])]
setup(packages=find_packages(include=["fastdyn", "fastdyn.*"]) + kernels)
