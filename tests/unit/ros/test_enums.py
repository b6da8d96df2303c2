"""The numbers in messages mean what the Python enums say: .msg files cannot import them."""

import pytest

from lexstack.transition import Phase
from lexstack.types import PlantStatus
from lexstack_bag.run.run import SolveStatus
from lexstack_interfaces.msg import Chi, PlantState, TransitionStatus


@pytest.mark.parametrize(
    ("kind", "message"),
    [(Phase, TransitionStatus), (PlantStatus, PlantState), (SolveStatus, Chi)],
)
def test_an_enum_has_the_constants_of_its_message(kind, message):
    constants = type(message).__prepare__(message.__name__, ())
    assert {each.name: each.value for each in kind} == {
        name: value for name, value in constants.items() if name.isupper()
    }
