"""Who made a bag: the versions of what ran, our own among them."""

import re
from pathlib import Path

import lexstack
from lexstack_bag.run.provenance import run_provenance
from support.scenario import ROOT, resolved


def test_every_package_that_a_bag_names_is_found():
    facts = run_provenance(resolved())
    assert [name for name, value in facts.items() if value == "not installed"] == []
    assert facts["lexstack"] == lexstack.__version__


def test_all_packages_have_the_version_that_the_library_says():
    files = [*ROOT.glob("ros2_ws/src/*/setup.py"), *ROOT.glob("ros2_ws/src/*/package.xml")]
    assert len(files) > 12
    found = {str(Path(file).relative_to(ROOT)): version_in(file) for file in files}
    for name, version in (("tf2_msgs", "0.36.0"), ("control_msgs", "5.3.0")):  # as in Jazzy
        assert found.pop(f"ros2_ws/src/{name}/package.xml") == version
    assert set(found.values()) == {lexstack.__version__}, found


def version_in(file):
    """Return the version that a package's description gives."""
    pattern = r"version=\"([^\"]+)\"," if file.suffix == ".py" else r"<version>([^<]+)</version>"
    return re.search(pattern, file.read_text(encoding="utf-8"))[1]
