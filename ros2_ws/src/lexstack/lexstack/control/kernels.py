"""The compiled code of a tick, loaded in the set-up."""

from lexstack.compiled import load

KERNELS = (
    "lexstack.hqp.kernel.checks",
    "lexstack.hqp.kernel.margins",
    "lexstack.hqp.kernel.regular",
    "lexstack.limits.kernel.box",
    "lexstack.robots.kernel.chain",
    "lexstack.tasks.kernel.linear",
    "lexstack.tasks.kernel.pose",
    "lexstack.tasks.kernel.residual",
)
"""All modules with what a tick calls, but for the solver's, which loads its own."""


def load_kernels() -> None:
    """Load them, or compile them where they never were: no tick waits for it."""
    load(*KERNELS)
