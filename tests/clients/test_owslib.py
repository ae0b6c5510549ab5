"""OWSLib, unchanged, drives the service: list, describe, execute, poll, fetch."""

import datetime
import importlib
import json
import math
import sys
import types

import pytest
import requests
from owslib.ogcapi.processes import Processes

from conftest import ROOT, wait_for

EPOCH = datetime.datetime(2000, 1, 1)

EXAMPLES = sorted(p for p in (ROOT / "api/examples").glob("*.json"))


def process_of(path, ids):
    """`key-herd-arrival.json` is a request of `key-herd`: the longest id that it begins with."""
    return max((i for i in ids if path.stem == i or path.stem.startswith(i + "-")), key=len)


class Runner:
    """Runs request files through the client; one that refers to others runs after them."""

    def __init__(self, base):
        self.base, self.client, self.done = base, Processes(base), {}
        self.ids = [p["id"] for p in self.client.processes()]

    def run(self, path):
        """The address of the finished job of a request file; each is run once."""
        if path not in self.done:
            inputs = self.resolved(json.loads(path.read_text())["inputs"], path.parent)
            answer = self.client.execute(process_of(path, self.ids), inputs=inputs, async_=True)
            assert answer["status"] in ("accepted", "running", "successful")
            location = self.client.response_headers["Location"]
            status = wait_for(self.base, location, 600)
            assert status["status"] == "successful", status
            self.done[path] = "/jobs/" + location.rstrip("/").split("/")[-1]
        return self.done[path]

    def resolved(self, value, folder):
        """The value with every relative href uploaded, or run, and replaced by its address."""
        if isinstance(value, list):
            return [self.resolved(v, folder) for v in value]
        if not isinstance(value, dict):
            return value
        href = value.get("href")
        if not isinstance(href, str) or href.startswith(("/", "http", "data:")):
            return {k: self.resolved(v, folder) for k, v in value.items()}
        if "#" in href:
            request, output = href.rsplit("#", 1)
            return {**value, "href": f"{self.run(folder / request)}/results/{output}"}
        kind = value.get("type", "application/octet-stream")
        reply = requests.post(self.base + "/assets", data=(folder / href).read_bytes(), headers={"Content-Type": kind})
        assert reply.status_code in (200, 201), reply.text
        return {**value, "href": "/assets/" + reply.json()["digest"]}


@pytest.fixture(scope="session")
def runner(server):
    return Runner(server)


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
def test_every_worked_example_runs_through_the_client(server, runner, example):
    job = runner.run(example)
    results = Processes(server)._request(path=job.lstrip("/") + "/results")
    assert results
    for output, value in results.items():
        if isinstance(value, dict) and "href" in value:
            reply = requests.get(server + value["href"] if value["href"].startswith("/") else value["href"])
            assert reply.status_code == 200 and reply.content, output


def test_the_processes_of_herds_are_chained_by_reference(server, runner):
    job = runner.run(ROOT / "api/examples/herd-animation.json")
    inputs = requests.get(server + job + "/results/manifest").json()["parameters"]
    assert "digest" in inputs["key_frames"][0]["herd"], "the key-herd was taken from another job"
    tracks = requests.get(server + job + "/results/tracks", headers={"Accept": "application/json"}).json()
    assert {row["id"] for row in tracks} == set(range(150))


def test_the_tracks_open_as_gltf(server, runner):
    import io

    import pygltflib

    job = runner.run(ROOT / "api/examples/herd-animation-ecosystem.json")
    text = requests.get(server + job + "/results/tracks.gltf").text
    scene = pygltflib.GLTF2().from_json(text)
    animals = json.load(io.StringIO(text))["nodes"][0]["children"]
    assert len(scene.nodes) == 1 + len(animals) and len(scene.animations[0].channels) == 2 * len(animals)
    size = {"SCALAR": 4, "VEC3": 12, "VEC4": 16}
    for accessor in scene.accessors:
        view = scene.bufferViews[accessor.bufferView]
        each = size[accessor.type] if accessor.componentType == pygltflib.FLOAT else 2
        assert accessor.count * each == view.byteLength
        assert view.byteOffset % 4 == 0 and view.byteOffset + view.byteLength <= scene.buffers[0].byteLength


def test_the_tracks_are_moving_features(server, runner):
    job = runner.run(ROOT / "api/examples/herd-animation-ecosystem.json")
    collection = requests.get(server + job + "/results/tracks.mfjson").json()
    assert collection["type"] == "FeatureCollection" and collection["crs"] is None
    for feature in collection["features"]:
        track = feature["temporalGeometry"]
        assert feature["type"] == "Feature" and feature["properties"]["simulated"] is True
        assert track["type"] == "MovingPoint" and track["interpolation"] == "Linear"
        assert len(track["datetimes"]) == len(track["coordinates"]) and track["datetimes"] == sorted(track["datetimes"])
        assert track["datetimes"][0] == "2000-01-01T00:00:00.000Z"
        properties = feature["temporalProperties"][0]
        assert properties["datetimes"] == track["datetimes"]
        assert all(len(properties[name]["values"]) == len(track["datetimes"]) for name in ("z", "heading"))


def movingpandas():
    """MovingPandas without what it draws with, which is three times as large as all the rest."""
    for name in ("matplotlib", "matplotlib.pyplot"):
        sys.modules.setdefault(name, types.ModuleType(name))
    return importlib.import_module("movingpandas.io")


@pytest.mark.filterwarnings("ignore")
def test_the_tracks_open_in_movingpandas(server, runner):
    job = runner.run(ROOT / "api/examples/herd-animation-ecosystem.json")
    features = requests.get(server + job + "/results/tracks.mfjson").json()
    rows = requests.get(server + job + "/results/tracks", headers={"Accept": "application/json"}).json()
    herd = movingpandas().read_mf_dict(features, traj_id_property="id")
    assert len(herd.trajectories) == 6
    for track in herd.trajectories:
        own, frame = [row for row in rows if row["id"] == track.id], track.df
        assert [(p.x, p.y) for p in frame.geometry] == [(row["x"], row["y"]) for row in own]
        assert list(frame["z"]) == [row["z"] for row in own]
        seconds = [(t - EPOCH).total_seconds() for t in frame.index.to_pydatetime()]
        assert seconds == pytest.approx([row["t"] for row in own], abs=1e-3)
        turns = [(a - row["heading"]) / (2 * math.pi) for a, row in zip(frame["heading"], own)]
        assert turns == pytest.approx([round(turn) for turn in turns], abs=1e-9)
