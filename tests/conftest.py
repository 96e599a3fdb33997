"""What holds for all tests: none depends on how busy the machine is, or on what ran before it."""

import pytest
from hypothesis import HealthCheck, settings

# A stall of the machine is no property of an example; the same examples are drawn in every run.
settings.register_profile(
    "any machine",
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("any machine")


def pytest_configure(config: pytest.Config) -> None:
    """Let matplotlib find its fonts before workers start.

    It does so once for each user, and says so on standard error where that takes longer than five
    seconds: programs that tests start must have nothing to say there.
    """
    if not hasattr(config, "workerinput"):
        import matplotlib.font_manager  # noqa: F401
