"""The pages of `--view` in a headless Chromium: view.py PROGRAM FOLDER. Leaves pages and screenshots in the folder."""

import html
import math
import pathlib
import subprocess
import sys

from browser import Browser, find_chromium

TURNED = "0 -1 0 {} 1 0 0 0.1 0 0 1 0.05\n"
COMMANDS = {
    "pair": "pair a.obj a.obj near.txt --mode all --budget-work 30000",
    "distance": "distance a.obj a.obj far.txt --budget-work 3000",
    "contacts": "contacts a.obj a.obj near.txt",
    "motion": "motion a.obj a.obj sweeps.txt",
    "scene": "scene .",
}
SIZES = [(800, 600), (400, 700)]


def torus(resolution):
    """An OBJ file with as many triangles as the square of this."""
    sides = resolution // 2
    lines = []
    for i in range(resolution):
        for j in range(sides):
            u, v = 2 * math.pi * i / resolution, 2 * math.pi * j / sides
            out = 1 + 0.4 * math.cos(v)
            lines.append(f"v {out * math.cos(u)} {out * math.sin(u)} {0.4 * math.sin(v)}")
    at = lambda i, j: i % resolution * sides + j % sides + 1
    for i in range(resolution):
        for j in range(sides):
            p, q, r, s = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            lines += [f"f {p} {q} {r}", f"f {p} {r} {s}"]
    return "\n".join(lines) + "\n"


def recording():
    """A ring that is fixed, one that goes through it, and one that stays away: the files of a scene."""
    bodies = "mesh 0 a.obj\nbody 0 0 static\nbody 1 0 moving\nbody 2 0 moving\n"
    lines = ["frame,body,px,py,pz,qw,qx,qy,qz"]
    for frame in range(12):
        for body, x in enumerate([0, 0.9 + 0.2 * frame, -3]):
            lines.append(f"{frame},{body},{x},0.1,0.05,1,0,0,0")
    return {"scene.txt": bodies, "poses.csv": "\n".join(lines) + "\n"}


def make_pages(program, folder):
    files = {"a.obj": torus(64), "large.obj": torus(264), "near.txt": TURNED.format(0.9), "far.txt": TURNED.format(3.5),
             "sweeps.txt": TURNED.format(4).strip() + " -3 0 0\n", **recording()}
    for name, text in files.items():
        (folder / name).write_text(text)
    large = "pair large.obj large.obj near.txt --mode all --budget-work 60000"
    for name, command in [*COMMANDS.items(), ("large", large)]:
        subprocess.run([program, *command.split(), "--view", f"{name}.html"], cwd=folder, check=True, capture_output=True)


class Pictures:
    """The page that a browser shows, and whether what is done to it changes the picture."""

    def __init__(self, browser, folder):
        self.browser, self.folder = browser, folder

    def settled(self):
        # Longer than it takes until a picture that moved is drawn in full.
        self.browser.run("new Promise(done => setTimeout(done, 600))")
        data = self.browser.ask("Page.captureScreenshot", format="png", clip=self.browser.run(
            "(r => ({x: r.x, y: r.y, width: r.width, height: r.height, scale: 1}))"
            "(document.querySelector('canvas').getBoundingClientRect())"))
        return data["data"]

    def assert_changed_by(self, what, action):
        before = self.settled()
        action()
        assert self.settled() != before, f"{what}: the picture stays the same"


def assert_fits(browser, name):
    wide = browser.run("[document.scrollingElement.scrollWidth, innerWidth]")
    assert wide[0] <= wide[1], f"{name}: {wide[0]} pixels on a screen of {wide[1]}"
    assert not browser.faults(), browser.faults()


def try_page(browser, folder, name):
    pictures = Pictures(browser, folder)
    script = lambda text: lambda: browser.run(text)
    for layer in range(browser.run("document.querySelectorAll('#key input').length")):
        label = browser.run(f"document.querySelectorAll('#key label')[{layer}].textContent")
        # Where all is known nothing is open, and the bodies may hide what meets.
        if not any(word in label for word in ["boxes", "triangles", "not known"]):
            pictures.assert_changed_by(f"{name}: {label}", script(f"document.querySelectorAll('#key input')[{layer}].click()"))
    browser.run("document.querySelectorAll('#key input:not(:checked)').forEach(box => box.click())")
    press = lambda key: lambda: browser.ask("Input.dispatchKeyEvent", type="keyDown", key=key)
    browser.run("document.querySelector('canvas').focus()")
    for key in ["ArrowLeft", "+", "0"]:
        pictures.assert_changed_by(f"{name}: {key}", press(key))
    # Scenes begin with the first frame.
    last = browser.run("document.querySelector('input[type=range]').value === '0'") and "11" or "0"
    slide = "(s => { s.value = {}; s.dispatchEvent(new Event('input')); })(document.querySelector('input[type=range]'))"
    before = browser.run("document.querySelector('#facts').textContent")
    browser.run(slide.replace("{}", last))
    assert browser.run("document.querySelector('#facts').textContent") != before, f"{name}: the numbers stay the same"
    assert_fits(browser, name)


def try_fingers(browser, folder):
    pictures = Pictures(browser, folder)
    touch = lambda kind, *points: browser.ask(
        "Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)])

    def pinch():
        touch("touchStart", (150, 150), (200, 200))
        touch("touchMove", (100, 100), (250, 250))
        touch("touchEnd")

    pictures.assert_changed_by("two fingers", pinch)


def orbit(browser):
    """Frames a second, and milliseconds of the processor for each, while the picture turns for three seconds."""
    before = browser.processor_seconds()
    seconds, frames = browser.run("""new Promise(done => {
      const canvas = document.querySelector("canvas");
      canvas.setPointerCapture = () => {};
      const send = (type, x) => canvas.dispatchEvent(new PointerEvent(type, { pointerId: 1, clientX: x, clientY: 99 }));
      send("pointerdown", 0);
      let frames = 0, start;
      const step = now => {
        start ??= now;
        if (now - start > 3000) return done([(now - start) / 1000, frames]);
        send("pointermove", ++frames);
        requestAnimationFrame(step);
      };
      requestAnimationFrame(step);
    })""")
    return frames / seconds, 1000 * (browser.processor_seconds() - before) / frames


def try_notebook(browser, folder):
    """The page in a frame that holds its text, as a notebook shows the answers of Python."""
    page = html.escape((folder / "pair.html").read_text())
    frame = f'<iframe srcdoc="{page}" style="width: 100%; height: 640px"></iframe>'
    (folder / "notebook.html").write_text(f"<!DOCTYPE html>{frame}")
    inner = "document.querySelector('iframe')?.contentDocument"
    browser.open(folder / "notebook.html", canvas=f"{inner}?.querySelector('canvas')")
    assert browser.run(f"{inner}.querySelector('#facts').textContent").startswith("Verdict")
    browser.shoot(folder / "notebook.png")
    assert not browser.faults(), browser.faults()


def main():
    if not find_chromium():
        print("Chromium is not installed: the pages of --view are not tried in a browser")
        return
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    make_pages(program, folder)
    for webgl in [True, False]:
        with Browser(webgl) as browser:
            for name in COMMANDS:
                # An emulated graphics processor is passed over, unless the address asks for it.
                mark = "#webgl" if webgl else ""
                for size in SIZES:
                    for scheme in ["light", "dark"]:
                        browser.open(folder / f"{name}.html", size, scheme == "dark", mark=mark)
                        assert browser.run("document.getElementById('excuse').hidden") == webgl
                        assert_fits(browser, name)
                        browser.shoot(folder / f"{name}-{size[0]}-{scheme}-{'webgl' if webgl else 'plain'}.png")
                try_page(browser, folder, name)
            browser.ask("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
            browser.open(folder / "pair.html", (400, 700), touch=True, mark=mark)
            try_fingers(browser, folder)
            try_notebook(browser, folder)
        print(f"{'WebGL' if webgl else 'without WebGL'}: {', '.join(COMMANDS)}")
    for webgl in [True, False]:
        with Browser(webgl) as browser:
            load = browser.open(folder / "large.html")
            size = (folder / "large.html").stat().st_size
            rate, cost = orbit(browser)
            print(f"2 x 69,696 triangles, {size} bytes: drawn after {load:.2f} s, {rate:.0f} frames a second, "
                  f"each {cost:.0f} ms of the processor")


main()
