"""Package description for colcon and pip."""

from setuptools import find_packages, setup

PACKAGE = "lexstack_testing"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Runs, faults, loads, several hosts on one machine: for tests and experiments.",
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
        "lexstack",
        "lexstack-bringup",
        "lexstack-plant",
        "lexstack-config",
        "lexstack-ros",
        "lexstack-sim",
        "mcap>=1.2",
        "mujoco>=4.0",
        "numpy>=2",
    ],
    zip_safe=False,
)
