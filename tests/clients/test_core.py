"""The core of the OGC API - Processes 1.0 abstract tests, asked as the official suite asks."""

import time

import pytest
import requests

from conftest import wait_for

JSON = {"Accept": "application/json"}
CORE = "http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/"
EXCEPTIONS = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/"


def get(server, path, **kw):
    return requests.get(server + path, headers={**JSON, **kw.pop("headers", {})}, **kw)


def execute(server, inputs, prefer="respond-async ", process="echo", **more):
    return requests.post(
        f"{server}/processes/{process}/execution",
        json={"inputs": inputs, **more},
        headers={**JSON, "Prefer": prefer},
    )


def test_the_landing_page_links_to_everything(server):
    page = get(server, "/")
    assert page.status_code == 200
    rels = {link["rel"] for link in page.json()["links"]}
    assert rels & {"service-desc", "service-doc"}
    for rel in ("conformance", "processes", "job-list"):
        assert f"http://www.opengis.net/def/rel/ogc/1.0/{rel}" in rels


def test_conformance_names_the_classes(server):
    classes = get(server, "/conformance").json()["conformsTo"]
    for name in ("core", "ogc-process-description", "json", "oas30", "job-list", "dismiss"):
        assert CORE + name in classes


def test_the_list_of_processes_obeys_its_limit(server):
    assert len(get(server, "/processes?limit=1").json()["processes"]) == 1
    for process in get(server, "/processes?limit=100").json()["processes"]:
        assert process["id"] and process["version"]


@pytest.mark.parametrize("limit", ["0", "-1", "many", "10001"])
def test_a_limit_out_of_range_is_refused(server, limit):
    assert get(server, f"/processes?limit={limit}").status_code == 400


def test_an_unknown_process_is_named_so(server):
    reply = get(server, "/processes/no-such-thing")
    assert reply.status_code == 404 and reply.json()["type"] == EXCEPTIONS + "no-such-process"


def test_an_unknown_job_is_named_so(server):
    for path in ("", "/results"):
        reply = get(server, "/jobs/no-such-job" + path)
        assert reply.status_code == 404 and reply.json()["type"] == EXCEPTIONS + "no-such-job"


def test_invalid_inputs_are_refused_as_json_where_only_that_is_accepted(server):
    reply = execute(server, {"no-such-input": 1})
    assert reply.status_code == 400
    assert reply.headers["Content-Type"].startswith("application/json")
    problem = reply.json()
    assert problem["code"] and problem["errors"][0]["pointer"]


def test_problems_are_problem_documents_for_everybody_else(server):
    reply = requests.get(server + "/processes/no-such-thing", headers={"Accept": "*/*"})
    assert reply.headers["Content-Type"].startswith("application/problem+json")


def test_an_asynchronous_job_is_created_followed_and_fetched(server):
    reply = execute(server, {"value": "teststring"})
    assert reply.status_code == 201
    location = reply.headers["Location"]
    assert reply.json()["jobID"] and reply.json()["type"] == "process"
    status = wait_for(server, location)
    assert status["status"] == "successful" and status["progress"] == 100
    results = requests.get(server + location + "/results", headers=JSON)
    assert results.status_code == 200 and "teststring" in results.text


def test_results_that_are_not_ready_are_said_not_to_be(server):
    location = execute(server, {"value": "later", "pause_s": 20}).headers["Location"]
    reply = get(server, location + "/results")
    assert reply.status_code == 404 and reply.json()["type"] == EXCEPTIONS + "result-not-ready"
    assert requests.delete(server + location).status_code == 200


def test_a_dismissed_job_stops_and_its_slot_is_free(server):
    location = execute(server, {"value": "never", "pause_s": 60}).headers["Location"]
    reply = requests.delete(server + location, headers=JSON)
    assert reply.status_code == 200 and reply.json()["status"] == "dismissed"
    begin = time.time()
    other = execute(server, {"value": "next"}).headers["Location"]
    assert wait_for(server, other)["status"] == "successful"
    assert time.time() - begin < 10
    assert get(server, location + "/results").status_code == 410


def test_the_job_list_holds_the_jobs(server):
    location = execute(server, {"value": "listed"}).headers["Location"]
    wait_for(server, location)
    jobs = get(server, "/jobs?limit=1000").json()["jobs"]
    assert location.rsplit("/", 1)[-1] in [job["jobID"] for job in jobs]
    assert all(job["processID"] == "echo" for job in get(server, "/jobs?processID=echo").json()["jobs"])
    assert len(get(server, "/jobs?limit=1").json()["jobs"]) == 1


def test_a_synchronous_answer_is_the_results_document(server):
    reply = execute(server, {"value": "now"}, prefer="respond-sync", response="document")
    assert reply.status_code == 200 and "now" in reply.text


def test_a_repeated_key_does_the_work_once(server):
    headers = {**JSON, "Prefer": "respond-async", "Idempotency-Key": "the-same-key"}
    url, body = server + "/processes/echo/execution", {"inputs": {"value": "once"}}
    first, second = (requests.post(url, json=body, headers=headers) for _ in range(2))
    assert first.headers["Location"] == second.headers["Location"]
    other = requests.post(url, json={"inputs": {"value": "other"}}, headers=headers)
    assert 400 <= other.status_code < 500


def test_events_tell_the_progress_and_end(server):
    location = execute(server, {"value": "events", "pause_s": 1}).headers["Location"]
    with requests.get(server + location + "/events", stream=True, timeout=20) as reply:
        assert reply.headers["Content-Type"].startswith("text/event-stream")
        text = "".join(line.decode() + "\n" for line in reply.iter_lines())
    assert "id:" in text and "data:" in text and "successful" in text


def test_bodies_that_are_not_json_are_refused(server):
    reply = requests.post(server + "/processes/echo/execution", data=b"{", headers={"Content-Type": "application/json"})
    assert reply.status_code == 400 and reply.json()["code"]


def test_an_asset_is_kept_once_and_served_in_ranges(server):
    first = requests.post(server + "/assets", data=b"0123456789", headers={"Content-Type": "text/plain"})
    again = requests.post(server + "/assets", data=b"0123456789", headers={"Content-Type": "text/plain"})
    assert (first.status_code, again.status_code) == (201, 200)
    url = server + "/assets/" + first.json()["digest"]
    part = requests.get(url, headers={"Range": "bytes=2-4"})
    assert part.status_code == 206 and part.content == b"234"
    etag = requests.get(url).headers["ETag"]
    assert requests.get(url, headers={"If-None-Match": etag}).status_code == 304


def test_health_metrics_and_documents_are_served(server):
    for path in ("/health", "/metrics", "/openapi.yaml"):
        assert requests.get(server + path).status_code == 200, path
