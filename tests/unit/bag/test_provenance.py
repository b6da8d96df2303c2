"""Who made a bag: the versions of what ran, our own among them."""

from lexstack_bag.run.provenance import run_facts
from support.scenario import resolved


def test_every_package_that_a_bag_names_is_found():
    facts = run_facts(resolved())
    missing = [name for name, value in facts.items() if value == "not installed"]
    assert missing == []
    assert facts["lexstack"][0].isdigit()
