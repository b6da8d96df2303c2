"""Package description for colcon and pip."""

from setuptools import find_packages, setup

PACKAGE = "lexstack_bag"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Recordings of lexstack: rosbag2 MCAP writer and reader, metrics, report, replay.",
    license="Apache-2.0",
    maintainer="The lexstack authors",
    maintainer_email="lexstack@users.noreply.github.com",
    python_requires=">=3.11",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "report/assets/*", "report/templates/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=[
        "imageio-ffmpeg",
        "jinja2>=3.1",
        "lexstack",
        "lexstack-config",
        "lexstack-sim",
        "markupsafe",
        "matplotlib",
        "mcap>=1.2",
        "numpy>=2",
        "pillow",
        "plotly>=6",
        "PyYAML>=6",
        "rosbags>=0.11",
        "trimesh>=5.2",
        "zstandard",
    ],
    extras_require={
        "parquet": ["pyarrow"],  # bags as tables
        "test": ["pytest"],  # by which colcon test finds test/
    },
    entry_points={
        "console_scripts": [
            "analyze = lexstack_bag.commands.analyze:main",
        ],
    },
    zip_safe=False,
)
