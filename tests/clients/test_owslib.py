"""OWSLib, unchanged, drives the service: list, describe, execute, poll, fetch."""

import json
import pathlib

import pytest
import requests
from owslib.ogcapi.processes import Processes

from conftest import ROOT, wait_for

EXAMPLES = sorted(p for p in (ROOT / "api/examples").glob("*.json"))


def process_of(path):
    """`ecosystem-valley.json` is an example of the process `ecosystem`."""
    return path.stem.split("-")[0] if path.stem.startswith("ecosystem") else path.stem


def uploaded(base, value, folder):
    """The request with every relative href uploaded and replaced by its asset."""
    if isinstance(value, list):
        return [uploaded(base, v, folder) for v in value]
    if not isinstance(value, dict):
        return value
    href = value.get("href")
    if isinstance(href, str) and not href.startswith(("/", "http", "data:")):
        kind = value.get("type", "application/octet-stream")
        reply = requests.post(base + "/assets", data=(folder / href).read_bytes(), headers={"Content-Type": kind})
        assert reply.status_code in (200, 201), reply.text
        return {**value, "href": "/assets/" + reply.json()["digest"]}
    return {k: uploaded(base, v, folder) for k, v in value.items()}


def test_the_landing_page_and_the_api_document_are_found(server):
    client = Processes(server)
    assert client.links
    assert client.conformance()["conformsTo"]
    assert client.api()["openapi"].startswith("3.0")


def test_every_listed_process_can_be_described(server):
    client = Processes(server)
    ids = [p["id"] for p in client.processes()]
    assert "echo" in ids and "ecosystem" in ids
    for process in ids:
        description = client.process(process)
        assert description["id"] == process and description["inputs"] and description["outputs"]


def test_a_quick_process_answers_at_once(server):
    assert "hello" in json.dumps(Processes(server).execute("echo", inputs={"value": "hello"}))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_every_worked_example_runs_through_the_client(server, example):
    body = uploaded(server, json.loads(example.read_text()), example.parent)
    client = Processes(server)
    answer = client.execute(process_of(example), inputs=body["inputs"], async_=True)
    location = client.response_headers["Location"]
    assert answer["status"] in ("accepted", "running", "successful")
    status = wait_for(server, location, 600)
    assert status["status"] == "successful", status
    results = client._request(path=location.split(server)[-1].lstrip("/") + "/results")
    assert results
    for output, value in results.items():
        if isinstance(value, dict) and "href" in value:
            reply = requests.get(server + value["href"] if value["href"].startswith("/") else value["href"])
            assert reply.status_code == 200 and reply.content, output
