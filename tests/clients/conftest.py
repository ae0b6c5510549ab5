"""Starts the program named by BIOTOPE_BIN on a free port with an empty data folder."""

import os
import pathlib
import socket
import subprocess
import time

import pytest
import requests

ROOT = pathlib.Path(__file__).resolve().parents[2]


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


@pytest.fixture(scope="session")
def binary():
    return os.environ.get("BIOTOPE_BIN", str(ROOT / "target/release/biotope"))


@pytest.fixture(scope="session")
def server(binary, tmp_path_factory):
    port = free_port()
    data = tmp_path_factory.mktemp("data")
    log = open(data / "log.txt", "wb")
    process = subprocess.Popen(
        [binary, "serve", "--port", str(port), "--data", str(data / "store"), "--threads", "2"],
        stdout=log,
        stderr=subprocess.STDOUT,
    )
    base = f"http://127.0.0.1:{port}"
    for _ in range(300):
        if process.poll() is not None:
            break
        try:
            if requests.get(base + "/health", timeout=1).ok:
                break
        except requests.ConnectionError:
            time.sleep(0.1)
    else:
        process.kill()
    assert process.poll() is None, (data / "log.txt").read_text()
    yield base
    process.terminate()
    process.wait(timeout=30)


def wait_for(base, location, seconds=120):
    """Polls a job until it has ended and returns its last status document."""
    url = location if location.startswith("http") else base + location
    end = time.time() + seconds
    while time.time() < end:
        status = requests.get(url, timeout=10).json()
        if status["status"] in ("successful", "failed", "dismissed"):
            return status
        time.sleep(0.05)
    raise AssertionError(f"{url} did not end within {seconds} s: {status}")
