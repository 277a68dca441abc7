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
# For one check each.
MORE = {
    "stopped": "scene . --budget-work 600",
    "unbounded": "distance a.obj a.obj far.txt --budget-work 1",
    "same": "pair cube.obj flipped.obj same.txt",
    "wall": "contacts cube.obj small.obj wall.txt",
    "robot": "robot robot.urdf --env env --configs configs.csv",
    "large": "pair large.obj large.obj near.txt --mode all --budget-work 60000",
}
SLIDE = "(s => {{ s.value = {1}; s.dispatchEvent(new Event('input')); }})(document.querySelector('{0}'))"
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


def cube(flipped, size=1):
    """A cube of this size whose sides are cut along one or the other diagonal."""
    lines = [f"v {size * (i & 1)} {size * (i >> 1 & 1)} {size * (i >> 2)}" for i in range(8)]
    for p, q, r, s in [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]:
        if flipped:
            p, q, r, s = q, r, s, p
        lines += [f"f {p + 1} {q + 1} {r + 1}", f"f {p + 1} {r + 1} {s + 1}"]
    return "\n".join(lines) + "\n"


def recording():
    """A ring that is fixed, one that goes through it, and one that stays away: the files of a scene."""
    bodies = "mesh 0 a.obj\nbody 0 0 static\nbody 1 0 moving\nbody 2 0 moving\n"
    lines = ["frame,body,px,py,pz,qw,qx,qy,qz"]
    for frame in range(12):
        for body, x in enumerate([0, 0.9 + 0.2 * frame, -3]):
            lines.append(f"{frame},{body},{x},0.1,0.05,1,0,0,0")
    return {"scene.txt": bodies, "poses.csv": "\n".join(lines) + "\n"}


def gripper():
    """A robot whose arm turns, with two fingers of which one follows the other; a wall; a configuration that is free, one
    in which the arm meets the wall."""
    shape = lambda kind, at: f'<collision><origin xyz="{at}"/><geometry><{kind}/></geometry></collision>'
    link = lambda name, kind, at="0 0 0": f'<link name="{name}">{shape(kind, at)}</link>'
    joint = lambda name, kind, parent, child, more: (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{more}</joint>')
    parts = [
        link("base", 'cylinder radius=".2" length=".4"', "0 0 .2"),
        link("arm", 'box size="1 .1 .1"', ".5 0 0"),
        link("left", 'sphere radius=".06"'),
        link("right", 'sphere radius=".06"'),
        joint("turn", "revolute", "base", "arm",
              '<origin xyz="0 0 .6" rpy=".1 0 .2"/><axis xyz="0 0 1"/><limit lower="-2" upper="2"/>'),
        joint("grip", "prismatic", "arm", "left",
              '<origin xyz="1.1 .1 0"/><axis xyz="0 1 0"/><limit lower="0" upper=".2"/>'),
        joint("follow", "prismatic", "arm", "right",
              '<origin xyz="1.1 -.1 0"/><axis xyz="0 -1 0"/><mimic joint="grip" multiplier="2"/>'),
    ]
    lines = [line.split() for line in cube(False).splitlines()]
    wall = "\n".join(f"v {float(x) - .5} {float(y) + .6} {z}" if kind == "v" else f"f {x} {y} {z}" for kind, x, y, z in lines)
    return {"robot.urdf": f"<robot name='gripper'>{''.join(parts)}</robot>", "env/wall.obj": wall + "\n",
            "configs.csv": "turn,grip\n-.7,.1\n1.2,.02\n"}


def make_pages(program, folder):
    files = {"a.obj": torus(64), "large.obj": torus(264), "near.txt": TURNED.format(0.9), "far.txt": TURNED.format(3.5),
             "sweeps.txt": TURNED.format(4).strip() + " -3 0 0\n", **recording(),
             "cube.obj": cube(False), "flipped.obj": cube(True), "small.obj": cube(False, 0.2),
             **gripper(),
             "wall.txt": "1 0 0 0.9 0 1 0 0.4 0 0 1 0.4\n", "same.txt": "1 0 0 1e-9 0 1 0 1e-9 0 0 1 1e-9\n"}
    (folder / "env").mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    for name, command in {**COMMANDS, **MORE}.items():
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

    def where(self, wanted):
        """Of the drawn picture without the texts in it: width, height, and x and y of each pixel of which a condition on its
        red `r`, green `g` and blue `b` holds (`ground` is the first pixel), as JavaScript has it."""
        over = "document.querySelectorAll('#axes, #labels, #excuse').forEach(part => part.style.visibility = '{}')"
        self.browser.run(over.format("hidden"))
        png = self.settled()
        self.browser.run(over.format(""))
        return self.browser.run(f"""(async () => {{
          const bytes = Uint8Array.from(atob("{png}"), letter => letter.charCodeAt(0));
          const image = await createImageBitmap(new Blob([bytes]));
          const {{ width, height }} = image;
          const context = new OffscreenCanvas(width, height).getContext("2d");
          context.drawImage(image, 0, 0);
          const {{ data }} = context.getImageData(0, 0, width, height);
          const ground = data.slice(0, 3).join();
          const there = [];
          for (let i = 0; i < width * height; i++) {{
            const [r, g, b] = data.subarray(4 * i, 4 * i + 3);
            if ({wanted}) there.push([i % width, Math.floor(i / width)]);
          }}
          return [width, height, there];
        }})()""")

    def count(self, wanted):
        return len(self.where(wanted)[2])

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
    # Keys work at once, wherever the focus is.
    press = lambda key: lambda: browser.ask("Input.dispatchKeyEvent", type="keyDown", key=key)
    for key in ["ArrowLeft", "+", "0", "x"]:
        pictures.assert_changed_by(f"{name}: {key}", press(key))
    assert browser.run("document.querySelector('#up [aria-pressed=true]').textContent") == "x", name
    browser.run("document.querySelectorAll('#up button')[2].click()")
    for layer in range(browser.run("document.querySelectorAll('#key input').length")):
        label = browser.run(f"document.querySelectorAll('#key label')[{layer}].textContent")
        # Where all is known nothing is open, and the bodies may hide what meets.
        if not any(word in label for word in ["boxes", "triangles", "not known"]):
            pictures.assert_changed_by(f"{name}: {label}", script(f"document.querySelectorAll('#key input')[{layer}].click()"))
    browser.run("document.querySelectorAll('#key input:not(:checked)').forEach(box => box.click())")
    for slider, value in [("opacity", 40), ("cut", 55)]:
        pictures.assert_changed_by(f"{name}: {slider}", script(SLIDE.format(f"#{slider}", value)))
        browser.run(SLIDE.format(f"#{slider}", {"opacity": 100, "cut": 0}[slider]))
    # Scenes begin with the first frame.
    last = browser.run("document.querySelector('input[type=range]').value === '0'") and "11" or "0"
    before = browser.run("document.querySelector('#facts').textContent")
    browser.run(SLIDE.format("input", last))
    assert browser.run("document.querySelector('#facts').textContent") != before, f"{name}: the numbers stay the same"
    assert_fits(browser, name)


def assert_whole(pictures, name):
    """All that is shown is in the picture, and fills it."""
    width, height, there = pictures.where("[r, g, b].join() !== ground")
    columns, rows = zip(*there)
    ends = min(columns), min(rows), width - 1 - max(columns), height - 1 - max(rows)
    assert min(ends) > 0, f"{name}: the picture cuts what it shows, {ends}"
    filled = max((max(columns) - min(columns)) / width, (max(rows) - min(rows)) / height)
    assert filled > 0.4, f"{name}: {filled} of the picture"


def try_whole(browser, folder, mark):
    """At the start and by the button, on each screen; without the grid, which may go on beyond the bodies."""
    pictures = Pictures(browser, folder)
    for name in ["unbounded", "contacts", "scene"]:
        for size in [*SIZES, (700, 300)]:
            browser.open(folder / f"{name}.html", size, mark=mark)
            browser.run("[...document.querySelectorAll('#key input')].pop().click()")
            assert_whole(pictures, f"{name} at the start, {size}")
            for key in "x+":
                browser.ask("Input.dispatchKeyEvent", type="keyDown", key=key)
            browser.run("document.getElementById('whole').click()")
            assert_whole(pictures, f"{name}, {size}, x up")


def try_unbounded(browser, folder, mark):
    """A distance stopped before anything is found: what is open is counted, told and drawn."""
    browser.open(folder / "unbounded.html", mark=mark)
    facts = browser.run("Object.fromEntries([...document.querySelectorAll('#facts tr')].map(row => [...row.cells].map(cell => cell.textContent)))")
    assert facts["Proven: at most"] == "not bounded" and facts["Likely, 80 of 100"] == "not known yet", facts
    assert int(facts["Open boxes"].split()[0]) > 0 and "anywhere" in facts["Open boxes"], facts
    key = "[...document.querySelectorAll('#key label')].find(label => label.textContent.includes('boxes')).click()"
    Pictures(browser, folder).assert_changed_by("boxes of an unbounded distance", lambda: browser.run(key))


def try_walls(browser, folder, mark):
    """What hides behind a body is seen through it, or where it is cut."""
    browser.open(folder / "wall.html", mark=mark)
    pictures = Pictures(browser, folder)
    shown = lambda: pictures.count("r > 190 && g > 190 && b < 110")
    before = shown()
    for slider, value, back in [("opacity", 10, 100), ("cut", 75, 0)]:
        browser.run(SLIDE.format(f"#{slider}", value))
        assert shown() > 2 * before + 5, f"{slider}: {shown()} pixels of contacts, before {before}"
        browser.run(SLIDE.format(f"#{slider}", back))
    for side in "012":
        browser.run(f"document.getElementById('side').value = '{side}'")
        pictures.assert_changed_by(f"cut along {side}", lambda: browser.run(SLIDE.format("#cut", 40)))
        browser.run(SLIDE.format("#cut", 0))


def try_same_place(browser, folder, mark):
    """Where surfaces of two bodies lie in the same place, the picture shows one of them."""
    browser.open(folder / "same.html", mark=mark)
    pictures = Pictures(browser, folder)
    browser.run("document.querySelectorAll('#key input')[2].click()")
    for turn in range(4):
        browser.run(f"document.querySelectorAll('#up button')[{turn % 3}].click()")
        for _ in range(turn):
            browser.ask("Input.dispatchKeyEvent", type="keyDown", key="ArrowUp")
            browser.ask("Input.dispatchKeyEvent", type="keyDown", key="+")
        orange = pictures.count("r > b + 20")
        assert orange == 0, f"turn {turn}: {orange} pixels of B among those of A"


def try_bounds(browser, folder, mark):
    """A bound that tells nothing is marked."""
    browser.open(folder / "pair.html", mark=mark)
    fact = "[...document.querySelectorAll('#facts tr')].find(row => row.cells[0].textContent === 'Pairs, at most').cells[1].textContent"
    last = browser.run("document.querySelector('input').max")
    for step, is_vague in [(0, True), (last, False)]:
        browser.run(SLIDE.format("input", step))
        assert ("says nothing yet" in browser.run(fact)) == is_vague, browser.run(fact)


def try_scene(browser, folder, mark):
    """Names, picking, lists of pairs, and the button that plays the frames."""
    pictures = Pictures(browser, folder)
    listed = "[...document.querySelectorAll('#pairs button')].map(button => button.textContent)"
    labels = "[...document.querySelectorAll('#labels output')].map(label => label.textContent)"
    browser.open(folder / "scene.html", mark=mark)
    browser.run("document.querySelectorAll('#pairs details').forEach(list => list.open = true)")
    assert pictures.settled() and browser.run(listed) == ["0: a.obj and 1: a.obj"], browser.run(listed)
    pictures.assert_changed_by("a pair of the list", lambda: browser.run("document.querySelector('#pairs button').click()"))
    assert browser.run(labels) == ["0: a.obj", "1: a.obj"], browser.run(labels)

    # Body 2 is alone at the left.
    browser.open(folder / "scene.html", mark=mark)
    browser.run("document.querySelectorAll('#up button')[2].click()")
    _, _, blue = pictures.where("b > r + 60")
    x, y = blue[len(blue) // 2]
    for kind in ["mousePressed", "mouseReleased"]:
        browser.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
    pictures.settled()
    (label,) = browser.run(labels)
    assert label.startswith("2: a.obj, triangle ") and "of 2: a.obj: 0" in browser.run("document.querySelector('#pairs').textContent")
    browser.ask("Input.dispatchKeyEvent", type="keyDown", key="Escape")
    pictures.settled()
    assert browser.run(labels) == []

    browser.ask("Input.dispatchKeyEvent", type="keyDown", key=" ")
    state, seen = "[document.querySelector('input').value, document.querySelector('.play').textContent]", set()
    while (now := browser.run(state)) != ["11", "Play"]:
        assert now[1] == "Stop" and len(seen) < 12, now
        seen.add(now[0])
    assert len(seen) > 2, f"frames that were played: {seen}"

    browser.open(folder / "stopped.html", mark=mark)
    browser.run("document.querySelectorAll('#pairs details').forEach(list => list.open = true)")
    assert pictures.settled() and browser.run(listed), "no pair is open"
    browser.shoot(folder / f"stopped-{'webgl' if mark else 'plain'}.png")
    lines = "[...document.querySelectorAll('#key label')].find(label => label.textContent.startsWith('lines')).click()"
    pictures.assert_changed_by("lines between bodies", lambda: browser.run(lines))


def try_robot(browser, folder, mark):
    """Links are coloured by clearance; sliders move joints to where the library has them, and nothing is claimed there."""
    pictures = Pictures(browser, folder)
    facts = "Object.fromEntries([...document.querySelectorAll('#facts tr')].map(row => [...row.cells].map(cell => cell.textContent)))"
    slide = lambda joint, value: browser.run(SLIDE.format(f"#joints input[aria-label={joint}]", value))
    browser.open(folder / "robot.html", mark=mark)
    assert browser.run(facts)["Pairs that meet"] == "0", browser.run(facts)
    browser.run(SLIDE.format("input", 1))
    assert browser.run(facts)["Closest pair"] == "arm and wall", browser.run(facts)
    browser.run("document.querySelectorAll('#pairs details').forEach(list => list.open = true)")
    pictures.settled()
    assert browser.run("[...document.querySelectorAll('#pairs button')].map(button => button.textContent)") == ["arm and wall"]
    browser.shoot(folder / f"robot-{'webgl' if mark else 'plain'}.png")
    orange = "r > b + 60 && r > g + 40"
    assert pictures.count(orange) > 100

    # A slider that is moved to where it is leaves all in its place.
    drawn = "[r, g, b].join() !== ground"
    before = {tuple(at) for at in pictures.where(drawn)[2]}
    slide("turn", 1.2)
    after = {tuple(at) for at in pictures.where(drawn)[2]}
    assert len(before ^ after) < len(before) / 500, f"{len(before ^ after)} of {len(before)} pixels"
    assert browser.run(facts)["Pairs that meet"] == "not asked" and browser.run("document.getElementById('pairs').hidden")
    assert pictures.count(orange) == 0
    for joint, value in [("turn", -1), ("grip", 0.2)]:
        pictures.assert_changed_by(f"robot: {joint}", lambda: slide(joint, value))
    browser.run(SLIDE.format("input", 0))
    assert browser.run("[...document.querySelectorAll('#joints output')].map(output => output.textContent)") == ["-40.1°", "0.100 m"]
    assert_fits(browser, "robot")


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
            for check in [try_whole, try_unbounded, try_walls, try_same_place, try_bounds, try_scene, try_robot]:
                check(browser, folder, mark)
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
