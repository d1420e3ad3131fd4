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
