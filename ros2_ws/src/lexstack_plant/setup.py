"""Package description for colcon and pip."""

from setuptools import find_packages, setup

PACKAGE = "lexstack_plant"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="ROS side of any plant of lexstack; the MuJoCo bridge.",
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
        "lexstack-config",
        "lexstack-ros",
        "lexstack-sim",
        "numpy>=2",
    ],
    entry_points={
        "console_scripts": [
            "plant_adapter = lexstack_plant.adapters.ros2_control:main",
            "sim_bridge = lexstack_plant.adapters.mujoco:main",
        ],
    },
    extras_require={"test": ["pytest"]},  # by which colcon test finds test/
    zip_safe=False,
)
