"""Package description for colcon and pip."""

from setuptools import find_packages, setup

PACKAGE = "lexstack"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Strict hierarchical QP control, smooth stack transitions, lexicographic MPC.",
    license="Apache-2.0",
    maintainer="The lexstack authors",
    maintainer_email="lexstack@users.noreply.github.com",
    python_requires=">=3.11",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=[
        "casadi>=3.7",
        "daqp>=0.11",
        "example-robot-data>=4.4",
        "numpy>=2",
        "pin>=4.1",
        "proxsuite>=0.8",
        "scipy>=1.13",
    ],
    extras_require={"fast": ["numba>=0.61"]},  # the compiled solver of the hierarchy
    zip_safe=False,
)
