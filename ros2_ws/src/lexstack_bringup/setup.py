"""Package description for colcon and pip."""

from setuptools import find_packages, setup

PACKAGE = "lexstack_bringup"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Starts, watches, plays and ends runs of lexstack.",
    license="Apache-2.0",
    maintainer="The lexstack authors",
    maintainer_email="lexstack@users.noreply.github.com",
    python_requires=">=3.11",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/launch", ["launch/run.launch.py"]),
    ],
    install_requires=[
        "lexstack",
        "lexstack-bag",
        "lexstack-config",
        "lexstack-plant",
        "lexstack-ros",
        "lexstack-sim",
        "numpy>=2",
        "PyYAML>=6",
    ],
    entry_points={
        "console_scripts": [
            "bringup = lexstack_bringup.commands.bringup:main",
            "demo = lexstack_bringup.commands.demo:main",
            "fit_spheres = lexstack_bringup.commands.fit_spheres:main",
            "find_plant = lexstack_bringup.commands.find_plant:main",
            "replay = lexstack_bringup.commands.replay:main",
        ],
    },
    extras_require={"test": ["pytest"]},  # by which colcon test finds test/
    zip_safe=False,
)
