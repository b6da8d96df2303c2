"""Package description for colcon and pip."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "lexstack_config"
HERE = Path(__file__).resolve().parent
CLONE = HERE.parents[2]  # its config/ is installed in share


def configuration() -> list[tuple[str, list[str]]]:
    """Return the files of config/ by the folder of share in which they are installed."""
    files = sorted(path for path in (CLONE / "config").rglob("*") if path.suffix in SUFFIXES)
    folders = sorted({path.parent for path in files})
    return [
        (
            f"share/{PACKAGE}/{folder.relative_to(CLONE).as_posix()}",
            [
                f"../../../{path.relative_to(CLONE).as_posix()}"
                for path in files
                if path.parent == folder
            ],
        )
        for folder in folders
    ]


SUFFIXES = (".yaml", ".json")

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Configuration of lexstack: YAML files as options of the library.",
    license="Apache-2.0",
    maintainer="The lexstack authors",
    maintainer_email="lexstack@users.noreply.github.com",
    python_requires=">=3.11",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        *configuration(),
    ],
    install_requires=[
        "lexstack",
        "numpy>=2",
        "PyYAML>=6",
    ],
    zip_safe=False,
)
