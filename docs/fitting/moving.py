"""The picture of the README that moves: one fit on its way from few control points to as many as its tolerance needs.

    docs/fitting/moving.py PROGRAM    # the server to start, such as target/debug/piad

Needs numpy.
"""

import json
import sys

from pictures import FOLDER, fetch, leaves, server

# Seconds that each curve is there, and that the last one stays.
STEP, STAY = 0.8, 3.0

HEAD = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="-5.2 -4.5 12.6 9.4" width="630" height="470" font-family="sans-serif" font-size="0.42">
<title>A curve on its way to its data points, with more control points from step to step</title>
<style>
text, circle { fill: #24292f } polyline { fill: none; stroke: #0969da; stroke-width: 0.07 }
@media (prefers-color-scheme: dark) { text, circle { fill: #e6edf3 } polyline { stroke: #58a6ff } }
</style>
"""


def frames(base: str) -> list:
    """Number of control points, largest distance and samples of iterations with more and more control points."""
    resource = json.loads(fetch(f"{base}/v1/jobs", json.dumps(leaves(0.01)).encode()))
    path, last = f"{base}{resource['links']['self']}/iterations", resource["iteration"]
    final = len(json.loads(fetch(f"{path}/{last}"))["control_points"])
    chosen, more = [], 0
    for k in range(last + 1):
        count = len(json.loads(fetch(f"{path}/{k}"))["control_points"])
        if k == last or more <= count < final:
            iteration = json.loads(fetch(f"{path}/{k}?view=samples&samples=200"))
            chosen.append((count, iteration["error"]["max"], iteration["samples"]))
            more = count + 2
    return chosen


def animated(attribute: str, values: list, times: list, seconds: float, mode: str) -> str:
    keys = ";".join(f"{time / seconds:.4f}" for time in times)
    return (
        f'<animate attributeName="{attribute}" values="{";".join(values)}" keyTimes="{keys}"'
        f' calcMode="{mode}" dur="{seconds:.1f}s" repeatCount="indefinite"/>'
    )


def drawing(data: list, frames: list) -> str:
    times = [STEP * i for i in range(len(frames))]
    seconds = times[-1] + STAY
    lines = [" ".join(f"{x:.2f},{-y:.2f}" for x, y in samples) for _, _, samples in frames]
    parts = [f'<circle cx="{x:.2f}" cy="{-y:.2f}" r="0.05"/>' for x, y in data]
    moves = animated("points", [*lines, lines[-1]], [*times, seconds], seconds, "linear")
    parts.append(f'<polyline points="{lines[-1]}">{moves}</polyline>')
    for i, (count, error, _) in enumerate(frames):
        shown = ["1" if i == k else "0" for k in range(len(frames))]
        # Without animations the last one is there.
        opacity = "1" if i + 1 == len(frames) else "0"
        changes = animated("opacity", shown, times, seconds, "discrete")
        text = f"{count} control points, at most {error:.2g} from the data"
        parts.append(f'<text x="-4.9" y="4.6" opacity="{opacity}">{text}{changes}</text>')
    return HEAD + "\n".join(parts) + "\n</svg>\n"


def main() -> int:
    with server(sys.argv[1]) as base:
        shown = frames(base)
    (FOLDER / "moving.svg").write_text(drawing(leaves(0.01)["curve"]["points"], shown))
    print(f"{len(shown)} curves, {', '.join(str(count) for count, _, _ in shown)} control points")
    return 0


if __name__ == "__main__":
    sys.exit(main())
