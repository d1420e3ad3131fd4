import os
import pathlib

import pytest

source = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture
def shared():
    folder = pathlib.Path(os.environ.get("PALPA_SHARED", source / "../shared")) / "data"
    if not folder.is_dir():
        pytest.skip("../shared/data is not there")
    return folder


def pytest_collection_modifyitems(config, items):
    """Where the data are hidden, only the tests that use them run: all others ran before."""
    if os.environ.get("PALPA_TESTS_HIDE_DATA") == "ON":
        config.hook.pytest_deselected(items=[item for item in items if "shared" not in item.fixturenames])
        items[:] = [item for item in items if "shared" in item.fixturenames]


def pytest_sessionfinish(session, exitstatus):
    if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED and os.environ.get("PALPA_TESTS_HIDE_DATA") == "ON":
        session.exitstatus = pytest.ExitCode.OK


@pytest.fixture
def palpa_program():
    program = pathlib.Path(os.environ["PALPA_BIN"]) / "palpa"
    if not program.exists():
        pytest.skip("the program palpa is not built")
    return program


@pytest.fixture
def needs_reader():
    if not (pathlib.Path(os.environ["PALPA_BIN"]) / "palpa-read").exists():
        pytest.skip("palpa-read is not built")
