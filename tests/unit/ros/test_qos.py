"""The page's table of topics: quality of service and depth are those that the nodes ask for.

The depth of a publisher is known to its own process alone: DDS tells it to nobody.
"""

from support.qos import created_qos, documented_qos


def test_the_page_names_every_topic_with_the_depth_that_the_sources_have():
    documented, created = documented_qos(), dict(created_qos("publisher"))
    assert len(created) > 12
    assert created == documented


def test_a_topic_has_one_quality_of_service_whoever_publishes_it():
    pairs = set(created_qos("publisher"))
    assert len(pairs) == len(dict(pairs))


def test_requests_and_releases_are_heard_as_the_page_says():
    heard = dict(created_qos("subscription"))
    for topic in ("/robot_a/request_stack", "/htmpc/release"):
        assert heard[topic] == ("reliable", "volatile", 50)
