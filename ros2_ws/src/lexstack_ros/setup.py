"""Package description for colcon and pip."""

from setuptools import find_packages, setup

PACKAGE = "lexstack_ros"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="ROS 2 nodes of lexstack: controller, stack solver, MPC, recorder, live page.",
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
        "lexstack-bag",
        "lexstack-config",
        "lexstack-sim",
        "numpy>=2",
        "viser>=1.1,<1.2",
        "websockets>=13.1",
    ],
    entry_points={
        "console_scripts": [
            "controller = lexstack_ros.controller.node:main",
            "hqp_controller = lexstack_ros.controller.node:main",
            "htmpc = lexstack_ros.planner.node:main",
            "recorder = lexstack_ros.recorder.node:main",
            "solver = lexstack_ros.solver.node:main",
            "stack_solver = lexstack_ros.solver.node:main",
            "view = lexstack_ros.view.node:main",
        ],
    },
    extras_require={
        "foxglove": ["foxglove-sdk>=0.30"],  # the run in Foxglove
        "test": ["pytest"],  # by which colcon test finds test/
    },
    zip_safe=False,
)
