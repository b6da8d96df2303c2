"""Package description for colcon and pip."""

from setuptools import find_packages, setup

PACKAGE = "lexstack_experiments"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Experiments and benches of lexstack: library and plant in one process.",
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
        "joblib>=1.4",
        "lexstack",
        "lexstack-bag",
        "lexstack-bringup",
        "lexstack-config",
        "lexstack-sim",
        "lexstack-testing",
        "markupsafe",
        "matplotlib",
        "mujoco>=4.0",
        "numpy>=2",
        "pillow",
        "pin>=4.1",
        "proxsuite>=0.8",
        "PyYAML>=6",
        "pyarrow",
        "quadprog>=0.1.13",
        "rosbags>=0.11",
        "scipy>=1.13",
    ],
    extras_require={
        "dask": ["distributed"],  # ./scripts/sweep --cluster tcp://...
        "ray": ["ray"],  # ./scripts/sweep --cluster ray:...
        "gurobi": ["gurobipy"],  # the solver of the authors of H; it needs a licence
        "peers": ["mink>=1.3", "pin-pink>=4", "piqp>=0.6"],  # measured beside our solver
        "test": ["pytest"],  # by which colcon test finds test/
    },
    entry_points={
        "console_scripts": [
            "bench = lexstack_experiments.commands.bench:main",
            "experiment = lexstack_experiments.commands.experiment:main",
            "sweep = lexstack_experiments.commands.sweep:main",
        ],
    },
    zip_safe=False,
)
