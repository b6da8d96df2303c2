"""Package description for colcon and pip."""

from setuptools import find_packages, setup

PACKAGE = "lexstack_experiments"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Experiments and benches of lexstack: core and plant in one process.",
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
        "lexstack-bag",
        "lexstack",
        "lexstack-sim",
        "numpy>=2",
    ],
    extras_require={"peers": ["pin-pink>=4", "piqp>=0.6"]},  # measured beside our solver
    zip_safe=False,
)
