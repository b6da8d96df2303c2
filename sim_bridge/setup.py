"""Package description for colcon and pip."""

from setuptools import find_packages, setup

PACKAGE = "lexstack_sim"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Simulated plant of lexstack: MuJoCo, joint impedance control, the bridge node.",
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
        "coal",
        "lexstack-core",
        "mujoco>=4.0",
        "numpy>=2",
        "pin>=4.1",
    ],
    entry_points={
        "console_scripts": [
            "sim_bridge = lexstack_sim.node:main",
        ],
    },
    zip_safe=False,
)
