"""Seconds that scikit-image, SciPy and pyrvo take for the tasks of `benches/herds.rs`.

`herds.py FOLDER` reads the tasks that the benchmark wrote there and prints one JSON object a
line: the name of the task, the peer, its seconds. Figures are the best of a few repetitions.
"""

import json
import pathlib
import sys
import time

import numpy as np
import pyrvo
from PIL import Image
from scipy import ndimage
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist
from skimage.color import rgb2lab
from skimage.draw import line
from skimage.feature import peak_local_max
from skimage.measure import regionprops_table
from skimage.segmentation import watershed


def seconds(work, repetitions=3):
    best = float("inf")
    for _ in range(repetitions):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return best


def extraction(task, folder):
    """Nearest mean colour in place of a support vector machine: scikit-image has none."""
    photo = np.asarray(Image.open(folder / task["photo"]))
    height = photo.shape[0]

    def work():
        lab = rgb2lab(photo).astype(np.float32)
        means = {}
        for mark in ("animal", "ground"):
            pixels = []
            for (x0, y0), (x1, y1) in task[mark]:
                rows, columns = line(int(height - y0), int(x0), int(height - y1), int(x1))
                pixels.append(lab[rows, columns])
            means[mark] = np.concatenate(pixels).mean(axis=0)
        score = ((lab - means["ground"]) ** 2).sum(axis=2) - ((lab - means["animal"]) ** 2).sum(axis=2)
        mask = ndimage.gaussian_filter(score, 1.2) > 0
        distance = ndimage.distance_transform_edt(mask)
        peaks = peak_local_max(distance, min_distance=4, labels=mask.astype(np.int32), exclude_border=False)
        markers = np.zeros(mask.shape, np.int32)
        markers[tuple(peaks.T)] = np.arange(1, len(peaks) + 1)
        regions = watershed(-distance, markers, mask=mask)
        names = ("centroid", "axis_major_length", "axis_minor_length", "orientation")
        return regionprops_table(regions, properties=names)

    return "scikit-image", seconds(work, 1)


def assignment(task, _folder):
    start, end = np.array(task["from"]), np.array(task["to"])

    def work():
        return linear_sum_assignment(cdist(start, end, "sqeuclidean"))

    return "SciPy", seconds(work, 1)


def steps(task, _folder):
    simulator = pyrvo.RVOSimulator(0.1, 4.8, 10, 2.0, 2.0, 0.8, 3.0)
    for x, y in task["places"]:
        simulator.add_agent((x, y))
    for agent in range(len(task["places"])):
        simulator.set_agent_pref_velocity(agent, tuple(task["velocity"]))
    count = task["steps"]

    def work():
        for _ in range(count):
            simulator.do_step()

    return "pyrvo", seconds(work, 1) / count


def main():
    folder = pathlib.Path(sys.argv[1])
    kinds = {"extraction": extraction, "assignment": assignment, "steps": steps}
    for task in json.loads((folder / "tasks.json").read_text()):
        peer, took = kinds[task["kind"]](task, folder)
        print(json.dumps({"name": task["name"], "peer": peer, "seconds": took}), flush=True)


if __name__ == "__main__":
    main()
